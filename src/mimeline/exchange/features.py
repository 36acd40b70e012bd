"""The types of Parquet columns as the library `datasets` tells them: in a schema and in a card."""

import json
from typing import Any

import pyarrow as pa

KEY = b"huggingface"  # of the schema's metadata


def with_features(schema: pa.Schema) -> pa.Schema:
    """The schema with its features in its metadata: `datasets` then need not guess them."""
    features = {field.name: _feature(field.type) for field in schema}
    told = {"info": {"features": features}}
    return schema.with_metadata({**(schema.metadata or {}), KEY: json.dumps(told)})


def for_card(fields) -> list[dict[str, Any]]:
    """The features of fields, as the YAML of a card's dataset_info lists them."""
    return [{"name": field.name} | _in_card(field.type) for field in fields]


def _feature(kind: pa.DataType) -> Any:
    """In the spelling of `datasets` up to version 3, which the later ones read as well."""
    if pa.types.is_list(kind):
        inner = _feature(kind.value_type)
        if pa.types.is_struct(kind.value_type):
            return [inner]
        return {"feature": inner, "_type": "Sequence"}
    if pa.types.is_struct(kind):
        return {field.name: _feature(field.type) for field in kind}
    return {"dtype": _name(kind), "_type": "Value"}


def _in_card(kind: pa.DataType) -> dict[str, Any]:
    if pa.types.is_list(kind):
        inner = kind.value_type
        return {"list": for_card(inner) if pa.types.is_struct(inner) else _name(inner)}
    if pa.types.is_struct(kind):
        return {"struct": for_card(kind)}
    return {"dtype": _name(kind)}


def _name(kind: pa.DataType) -> str:
    """double → float64: the name that `datasets` has for a plain type."""
    return {"double": "float64", "float": "float32"}.get(str(kind), str(kind))
