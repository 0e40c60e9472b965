"""The reservation of ROS domains, and waiting."""

import socket
import subprocess
import sys
from pathlib import Path

import pytest

from support.domains import DOMAIN_IDS, PARTICIPANTS, discovery_ports, reserve_domain_id
from support.waiting import wait_until

TESTS = Path(__file__).resolve().parents[2]


def test_domains_held_at_the_same_time_differ(tmp_path: Path) -> None:
    with reserve_domain_id(folder=tmp_path) as first, reserve_domain_id(folder=tmp_path) as second:
        assert first != second
        assert {first, second} <= set(DOMAIN_IDS)


def test_a_domain_is_free_again_afterwards(tmp_path: Path) -> None:
    with reserve_domain_id() as domain_id:
        pass
    with reserve_domain_id([domain_id], tmp_path) as again:
        assert again == domain_id


def test_a_domain_held_by_another_process_is_not_given_out(tmp_path: Path) -> None:
    with reserve_domain_id() as spare:  # a domain that nothing on this machine uses
        script = (
            "import sys; from pathlib import Path; from support.domains import reserve_domain_id\n"
            "with reserve_domain_id([int(sys.argv[1])], Path(sys.argv[2])): print('held', flush=True); sys.stdin.read()"
        )
        with subprocess.Popen(
            [sys.executable, "-c", script, str(spare), str(tmp_path)],
            cwd=TESTS,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        ) as holder:
            assert holder.stdout is not None
            assert holder.stdout.readline() == "held\n"
            with (
                pytest.raises(RuntimeError, match="every ROS domain of 1 is taken"),
                reserve_domain_id([spare], tmp_path),
            ):
                pass
            holder.kill()
        # A dead holder holds nothing.
        with reserve_domain_id([spare], tmp_path) as domain_id:
            assert domain_id == spare


@pytest.mark.parametrize("number", [0, 1, 2, PARTICIPANTS])
def test_a_domain_in_use_without_a_reservation_is_passed_over(number: int, tmp_path: Path) -> None:
    with reserve_domain_id() as spare, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        stranger.bind(("", discovery_ports(spare)[number]))
        with pytest.raises(RuntimeError, match="is taken"), reserve_domain_id([spare], tmp_path):
            pass


def test_waiting_ends_with_the_condition() -> None:
    spun: list[float] = []
    wait_until(lambda: len(spun) == 3, spin=spun.append)
    assert len(spun) == 3


def test_waiting_fails_with_its_message() -> None:
    with pytest.raises(AssertionError, match=r"not within 0\.01 s: no odometry"):
        wait_until(lambda: False, timeout=0.01, message=lambda: "no odometry")
