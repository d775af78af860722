"""Wrong inputs of every command but `daq import`: exit code 2, the reason, and no file is changed or left behind."""

import shlex
import shutil
from pathlib import Path

import pytest

from recordings.rig import simulated_rig
from tests.conftest import Runner
from tests.daq.feedforward.given import write_nominal_torque
from tests.drivers.simulated.dictionaries import MADE_UP
from tests.running import DRIVES
from trajectories import load

BENCH = f'name = "bench"\n{{}}\n{DRIVES}'
SERIAL = '[bus]\ntransport = "serial"\nports = ["{}"]\n'
FILES = {
    "far.csv": "time,x,y,z\n" + "".join(f"{k / 10},2.0,0,-0.7\n" for k in range(50)),
    "effect.toml": '[[effects]]\nname = "magic"\n',
    "noise.mcap": "noise",
    "there.mcap": "precious",
    "there.toml": "mine",
    "there.png": "mine",
    "slow.toml": BENCH.format("[limits]\nspeed = 0.5"),
    "weak.toml": BENCH.format("[limits]\ntorque = 15.0"),
    "tight.toml": BENCH.format('rate = 100\n[bus]\ninterface = "virtual"\n[limits]\njoint_max = -0.1'),
    "blind.toml": BENCH.format("").replace("[[drives]]", '[[drives]]\ntorque_source = "none"'),
    "nocan.toml": BENCH.format('[bus]\ninterface = "socketcan"\nchannel = "nocan7"'),
    "virtual.toml": BENCH.format('[bus]\ninterface = "virtual"\nchannel = "x"'),
    "line.toml": BENCH.format("rate = 30.0\n" + SERIAL.format("simulated")),
    "gone.toml": BENCH.format("rate = 30.0\n" + SERIAL.format("/dev/no/such/port")),
    "quick.toml": BENCH.format("rate = 60.0\n" + SERIAL.format("simulated") + "baud = 460800"),
    "dcf.toml": BENCH.format("") + 'dcf = "none.dcf"\n',
    "interpolated.toml": BENCH.format("").replace("node_id", 'mode = "interpolated"\nnode_id'),
    "axis.toml": (
        'name = "axis"\nmechanism = "axes"\n[[axes]]\n[bus]\ninterface = "virtual"\n[[drives]]\nnode_id = 1\n'
    ),
}
SAMPLE = Path(__file__).parents[2] / "recordings" / "samples" / "fig5a.mcap"
REPLAY = f"replay {SAMPLE} --bus socketcan:nocan7"
FED = "record --traj fig5b --cycles 1 --rate 60 --feedforward torque.csv --rig"
PROPOSE = "rig propose --bus virtual:x"

REFUSED = {
    # daq record
    "record --traj fig9": "unknown trajectory 'fig9'",
    "record --traj far.csv": "limb",
    "record": "--traj",
    "record --traj fig5a --rig slow.toml": "speed",
    "record --traj fig5a --out run.csv": "a recording's name (.mcap) expected, run.csv found",
    "record --traj fig5a --rig none.toml": "none.toml does not exist",
    "record --traj fig5a --rig dcf.toml": "none.dcf",
    "record --traj fig5a --rig nocan.toml": "cannot be opened",
    "record --traj fig5a --rate 1250": "choose --rate",
    "record --traj fig5a --rate 333": "choose a rate such as",
    "record --traj fig5a --out there.mcap": "a new name expected, there.mcap exists and no recording is replaced",
    "record --traj fig5a --out no/such/folder.mcap": "does not exist",
    "record --traj fig5a --sim effect.toml": "magic",
    "record --traj fig5a --rig nocan.toml --hidden 1": "daq sim",
    "record --traj fig5a --dry-run --hidden 1": "drop --hidden",
    "record --traj fig5a --duration 3": "how long to --listen",
    "record --traj fig5a --rig line.toml --rate 50": "choose --rate 31 or less",
    "record --traj fig5a --rig gone.toml": "serial port '/dev/no/such/port' cannot be opened",
    **{
        f"record --traj fig5a {shown} {other}": shown
        for shown in ("--live", "--foxglove", "--status")
        for other in ("--dry-run", "--listen")
    },
    f"{FED} interpolated.toml": "mode 7 has no 60B2h",
    f"{FED} weak.toml": "limits.torque",
    f"{FED} quick.toml": "joint 1: a torque can be fed forward only to a drive with",
    "record --traj fig5b --accept assumed-gain": "--accept assumed-gain belongs to --feedforward",
    "record --traj fig5b --stop-on-alarm": "--stop-on-alarm belongs to --watch",
    "record --traj fig5b --watch none.json": "none.json",
    "record --traj fig5b --hidden x@60": "a seed such as 7, or 7@60",
    "record --traj fig5b --hidden 1@-1": "a seed such as 7, or 7@60",
    # daq record --listen
    "record --listen": "--listen needs --rig",
    "record --listen --duration nan": "a number above 0 expected, 'nan' found",
    "record --listen --dry-run --rig nocan.toml": "either --listen or --dry-run expected",
    "record --listen --rig virtual.toml": "ends at this program",
    "record --listen --rig line.toml": "a CAN bus expected",
    "record --listen --rig nocan.toml": "cannot be opened",
    "record --listen --rig nocan.toml --traj fig5z": "unknown trajectory",
    # Commissioning
    "jog --joint 4 --by 0.1": "--joint: 1 to 3 expected, 4 found",
    "jog --joint 1 --by 0": "a way expected",
    "jog --joint 1 --by 0.5 --rig tight.toml": "limits.joint_min or joint_max",
    "jog --joint 1 --by 0.1 --rig axis.toml": "the simulated machine is a delta robot",
    "jog --joint 1 --by 0.1 --rig nocan.toml --sim effect.toml": "daq sim",
    "axis-check --payload 1 --rig blind.toml": "--payload is weighed by the torque",
    "home --rig line.toml": "drives on a CAN bus expected, serial lines found",
    "response --joint 4": "1 to 3 expected, 4 found",
    "response --joint 1 --amplitude 0": "--amplitude",
    # daq replay
    f"replay {SAMPLE}": "--bus",
    f"replay {SAMPLE} --bus socketcan": "INTERFACE:CHANNEL[,KEY=VALUE...] expected",
    f"replay {SAMPLE} --bus virtual:x": "ends at this program",
    f"replay {SAMPLE} --bus pigeon:x": "CAN interface 'pigeon'",
    REPLAY: "cannot be opened",
    f"{REPLAY} --direction both": "would MOVE real ones",
    f"{REPLAY} --id 0x555": "none of 21893 recorded ones is chosen",
    f"{REPLAY} --id all": "--id",
    f"{REPLAY} --speed 0": "--speed",
    f"{REPLAY} --speed nan": "a number above 0 expected, 'nan' found",
    f"{REPLAY} --loop 0": "--loop",
    # daq rig propose
    f"{PROPOSE}": "either --eds FILE or --scan expected",
    f"{PROPOSE} --scan --eds drive.eds": "either --eds FILE or --scan expected",
    f"{PROPOSE} --eds missing.eds": "missing.eds does not exist",
    "rig propose --eds drive.eds --bus can0": "INTERFACE:CHANNEL[,KEY=VALUE...] expected",
    f"{PROPOSE} --eds drive.eds --nodes 1,1,2": "axis 2 of a CiA 402 drive expected, no controlword (6840h)",
    f"{PROPOSE} --eds drive.eds --nodes a": "node ids such as 1,2,3",
    f"{PROPOSE} --eds drive.eds --eds drive.eds": "one file for all joints or 3",
    f"{PROPOSE} --eds drive.sim.toml": "an EDS or DCF file",
    f"{PROPOSE} --eds drive.eds --out drive.eds --force": "one of the inputs",
    f"{PROPOSE} --eds drive.eds --out there.toml": "a new name expected, there.toml exists",
    # Files
    "info noise.mcap": "noise.mcap is not an MCAP file",
    "recover there.mcap --out c.mcap --in-place": "either --out or --in-place",
    "trajectories fig6": "unknown trajectory 'fig6'",
    "trajectories none.csv": "none.csv does not exist",
    "trajectories fig5a --rig none.toml": "none.toml does not exist",
    "trajectories fig5a --out there.png": "a new name expected, there.png exists",
    "trajectories fig5a --out fig5a.jpg": "ending in .png expected",
    "trajectories --out all.png": "name it",
    "sim --rig line.toml": "bus.ports to names in the file system",
}
"""Command lines, and what each error says."""


@pytest.fixture(scope="session")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with files that are wrong, or in the way."""
    folder = tmp_path_factory.mktemp("refusals")
    for name, text in FILES.items():
        (folder / name).write_text(text)
    MADE_UP["slow"].write(folder)
    rig = simulated_rig().at_rate(60.0)
    write_nominal_torque(folder / "torque.csv", load("fig5b", rig, 1), rig)
    return folder


def contents(folder: Path) -> dict[Path, bytes]:
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.mark.parametrize("line", REFUSED)
def test_wrong_input_is_explained(line: str, files: Path, daq_in_process: Runner, tmp_path: Path) -> None:
    shutil.copytree(files, tmp_path, dirs_exist_ok=True)
    before = contents(tmp_path)
    done = daq_in_process(*shlex.split(line))
    assert done.code == 2, done.err
    assert REFUSED[line] in done.err
    assert contents(tmp_path) == before
