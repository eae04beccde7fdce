"""The processor that programs are compiled for."""

import platform

from estexp_jax.lanes.processor import processor_name


def test_it_names_the_machine_and_fits_a_folder_name() -> None:
    assert processor_name().startswith(platform.machine())
    assert "/" not in processor_name()
    assert processor_name() == processor_name()
