"""The configuration: one section per stage, each key with its unit and meaning.

`config/config.yaml` and `config/config.schema.json` are written from the models in this folder
(`mimeline config`); unknown keys are refused.
"""

from mimeline.config.section import Section
from mimeline.config.sections import Config
from mimeline.config.validation import checked, validate, value_of
from mimeline.config.writing import default_yaml, json_schema

__all__ = ["Config", "Section", "checked", "default_yaml", "json_schema", "validate", "value_of"]
