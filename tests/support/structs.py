"""Draw values of msgspec structs: every key that a file may have, within its limits."""

from collections.abc import Mapping
from typing import Any

from hypothesis import strategies as st
from msgspec import inspect

MOST = 3  # items of a list or a table
Given = Mapping[str, st.SearchStrategy[Any]]


def contents(kind: type[Any], given: Given) -> st.SearchStrategy[dict[str, Any]]:
    """Draw the content of a struct, as of a file of it.

    `given` has strategies for keys with limits beyond their types, by `key` or
    `Struct.key`, and for patterns of texts.
    """
    return _values(inspect.type_info(kind), given)


def _values(shape: inspect.Type, given: Given) -> st.SearchStrategy[Any]:
    match shape:
        case inspect.StructType():
            kinds = {field.encode_name: field for field in shape.fields}
            drawn = {key: _values(one.type, given) for key, one in kinds.items()}
            drawn |= {key: given[key] for key in kinds if key in given}
            own = {key: f"{shape.cls.__name__}.{key}" for key in kinds}
            drawn |= {key: given[name] for key, name in own.items() if name in given}
            return st.fixed_dictionaries(
                {key: drawn[key] for key, one in kinds.items() if one.required},
                optional={key: drawn[key] for key, one in kinds.items() if not one.required},
            )
        case inspect.UnionType():
            some = [kind for kind in shape.types if not isinstance(kind, inspect.NoneType)]
            return st.one_of(*(_values(kind, given) for kind in some))
        case inspect.ListType():
            most = min(shape.max_length or MOST, max(MOST, shape.min_length or 0))
            item = _values(shape.item_type, given)
            return st.lists(item, min_size=shape.min_length or 0, max_size=most)
        case inspect.TupleType():
            return st.tuples(*(_values(kind, given) for kind in shape.item_types)).map(list)
        case inspect.DictType():
            keys, values = _values(shape.key_type, given), _values(shape.value_type, given)
            return st.dictionaries(keys, values, max_size=MOST)
        case inspect.LiteralType():
            return st.sampled_from(shape.values)
        case inspect.BoolType():
            return st.booleans()
        case inspect.IntType():
            return st.integers(shape.ge, shape.le)
        case inspect.FloatType():
            return st.floats(
                shape.gt if shape.ge is None else shape.ge,
                shape.lt if shape.le is None else shape.le,
                exclude_min=shape.gt is not None,
                exclude_max=shape.lt is not None,
                allow_nan=False,
                allow_infinity=False,
            )
        case inspect.StrType(pattern=str(pattern)):
            return given[pattern] if pattern in given else st.from_regex(pattern, fullmatch=True)
        case inspect.StrType():
            return st.text(st.characters(codec="utf-8"), max_size=20)
    raise TypeError(f"no values are known for the type {shape}")
