"""schemas/*.toml as Python sees them."""

import pathlib
import tomllib

import pyarrow as pa

SCHEMAS = pathlib.Path(__file__).resolve().parents[2] / "schemas"
SCALARS = {
    "bool": pa.bool_(),
    "int8": pa.int8(),
    "int16": pa.int16(),
    "int32": pa.int32(),
    "uint32": pa.uint32(),
    "uint64": pa.uint64(),
    "float32": pa.float32(),
    "float64": pa.float64(),
    "utf8": pa.string(),
}


def names():
    """The tables."""
    return sorted(path.stem for path in SCHEMAS.glob("*.toml") if path.stem != "inputs")


def inputs():
    """What a net can read: the raw columns of a row, then the inputs that a formula computes."""
    return tomllib.loads((SCHEMAS / "inputs.toml").read_text())["input"]


def raw_columns(which="all"):
    """The raw columns as columns of a schema, all or those in the "world" frame."""
    columns = [entry for entry in inputs() if "formula" not in entry]
    return [
        {**entry, "type": "float32", "nullable": False}
        for entry in columns
        if which == "all" or entry["frame"] == which
    ]


def load(name):
    """One schema with the columns of the one that it extends in front."""
    schema = tomllib.loads((SCHEMAS / f"{name}.toml").read_text())
    columns = [raw_columns(c["raw"]) if "raw" in c else [c] for c in schema["column"]]
    schema["column"] = sum(columns, [])
    if base := schema.get("extends"):
        schema["column"] = load(base)["column"] + schema["column"]
    return schema


def arrow_type(name):
    if name.startswith("list<"):
        return pa.list_(arrow_type(name[5:-1]))
    return SCALARS[name]


def same_type(a, b):
    """Whether two Arrow types hold the same values; what a list calls its items is no matter."""
    if pa.types.is_list(a) and pa.types.is_list(b):
        return same_type(a.value_type, b.value_type)
    return a == b


def differences(schema, found, others_allowed=False):
    """What differs between a schema of schemas/ and an Arrow schema, in words."""
    wrong = []
    for column in schema["column"]:
        name = column["name"]
        if name not in found.names:
            wrong.append(f"{name}: missing")
            continue
        field = found.field(name)
        if not same_type(field.type, arrow_type(column["type"])):
            wrong.append(f"{name}: {field.type}, not {column['type']}")
        if field.nullable != column["nullable"]:
            wrong.append(f"{name}: nullable is {field.nullable}")
        metadata = field.metadata or {}
        for key in ("unit", "frame", "meaning"):
            if metadata.get(key.encode(), b"").decode() != column[key]:
                wrong.append(f"{name}: {key} is {metadata.get(key.encode())}")
    known = {column["name"] for column in schema["column"]}
    if not others_allowed:
        wrong += [f"{name}: not in the schema" for name in found.names if name not in known]
    metadata = found.metadata or {}
    for key, value in (("schema", schema["name"]), ("schema_version", str(schema["version"]))):
        if metadata.get(f"rrf.{key}".encode(), b"").decode() != value:
            wrong.append(f"metadata rrf.{key} is {metadata.get(f'rrf.{key}'.encode())}")
    return wrong
