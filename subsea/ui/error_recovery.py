"""Leave Dear ImGui in order where drawing fails within open scopes."""

from collections.abc import Iterator
from contextlib import contextmanager

from imgui_bundle import imgui


@contextmanager
def recovering_errors() -> Iterator[None]:
    """End all open scopes of ImGui if drawing fails within."""
    before, io = imgui.internal.ErrorRecoveryState(), imgui.get_io()
    imgui.internal.error_recovery_store_state(before)
    try:
        yield
    except Exception:
        io.config_error_recovery_enable_assert = False
        imgui.internal.error_recovery_try_to_recover_state(before)
        io.config_error_recovery_enable_assert = True
        raise
