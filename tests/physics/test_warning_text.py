"""MuJoCo's warnings are reported in words."""

import pytest

mujoco = pytest.importorskip("mujoco")
from wmspec.backends.mujoco.world import warning_text  # noqa: E402  MuJoCo may not be here


def test_every_warning_has_words() -> None:
    kinds = [int(kind) for kind in mujoco.mjtWarning.__members__.values() if kind != mujoco.mjtWarning.mjNWARNING]
    texts = {warning_text([int(kind == one) for one in range(len(kinds))], 0.25) for kind in kinds}
    assert len(texts) == len(kinds)
    assert all(text.startswith("MuJoCo gives up at 0.25 s: ") and text[-1] != " " for text in texts)


def test_the_counts_are_those_of_mujoco() -> None:
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body><freejoint/><geom size='1'/></body></worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    data.qvel[0] = float("nan")
    previous = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda _: None)
    try:
        mujoco.mj_step(model, data)
    finally:
        mujoco.set_mju_user_warning(previous)
    assert warning_text(data.warning.number, 0.0).endswith("velocities grow without bound")
