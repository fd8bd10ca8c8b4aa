"""Addresses are an IP address and a port."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from subsea.stage.theatre.theatre_file import parse_address


@given(st.ip_addresses(), st.integers(1, 65535))
def test_an_address_is_read_as_it_is_written(ip, port):
    text = f"[{ip}]:{port}" if ip.version == 6 else f"{ip}:{port}"
    assert parse_address(text) == (ip, port)


@pytest.mark.parametrize(
    "text", ["", "1.2.3.4", "host:5560", "1.2.3.4:0", "1.2.3.4:٣", "1.2.3.4:99999"]
)
def test_anything_else_is_refused(text):
    with pytest.raises(ValueError, match="expected an IP address and a port"):
        parse_address(text)
