# SPDX-License-Identifier: Apache-2.0
"""A model to be spoilt, and a file to write it to."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import yaml
from spoilt_models import Content, Write

import linkedplane_ros

BUNDLED = Path(linkedplane_ros.__file__).parent / 'models' / 'deltoid.yaml'


@pytest.fixture
def content() -> Content:
    """Return what the bundled model file states, to be spoilt."""
    loaded: Content = yaml.safe_load(BUNDLED.read_text(encoding='utf-8'))
    return loaded


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Return a writer of model files: a text is written as it stands, anything else as YAML."""

    def write_model(model: Any) -> Path:
        path = tmp_path / 'muscle.yaml'
        text = model if isinstance(model, str) else yaml.safe_dump(model, allow_unicode=True)
        path.write_text(text, encoding='utf-8')
        return path

    return write_model
