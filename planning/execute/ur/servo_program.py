"""The program that a controller of Universal Robots runs while we send setpoints.

`servoj` follows a target that it reads anew from input registers in every cycle. The watchdog ends
the program, and so brings the robot to rest, if the registers are not written any more.
"""

from dataclasses import dataclass
from string import Template

# Registers of the controller that RTDE clients may use begin with 24.
COMMAND = "input_int_register_24"
TARGETS = tuple(f"input_double_register_{24 + i}" for i in range(6))
RUNNING = "output_int_register_24"
IDLE, SERVO = 0, 1

_PROGRAM = Template("""def wayproof_servo():
  rtde_set_watchdog("input_int_register_24", $watchdog, "stop")
  write_output_integer_register(24, 1)
  while read_input_integer_register(24) == 1:
    q = [$targets]
    servoj(q, t=$period, lookahead_time=$lookahead, gain=$gain)
  end
  stopj($deceleration)
  write_output_integer_register(24, 0)
end
""")


@dataclass(frozen=True)
class ServoOptions:
    """How the controller follows setpoints.

    Attributes:
        frequency: Of setpoints and of measurements [Hz]; 500 divided by a whole number.
        lookahead: Time over which `servoj` smooths its targets, 0.03 to 0.2 [s].
        gain: Proportional gain of `servoj`, 100 to 2000.
        watchdog: Least frequency of setpoints before the program ends [Hz].
        deceleration: Of the joints once it ends [rad/s^2].
    """

    frequency: float = 125.0
    lookahead: float = 0.03
    gain: float = 300.0
    watchdog: float = 10.0
    deceleration: float = 4.0

    @property
    def period(self) -> float:
        """Time between setpoints [s]."""
        return 1.0 / self.frequency


def servo_program(options: ServoOptions) -> str:
    """Return the program in URScript."""
    return _PROGRAM.substitute(
        watchdog=f"{options.watchdog:g}",
        targets=", ".join(f"read_input_float_register({24 + i})" for i in range(6)),
        period=f"{options.period:g}",
        lookahead=f"{options.lookahead:g}",
        gain=f"{options.gain:g}",
        deceleration=f"{options.deceleration:g}",
    )
