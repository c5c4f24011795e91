"""Names of settings: those that are wrong, and the nearest that are right."""

from collections.abc import Mapping
from difflib import get_close_matches

from service.settings import CONFIG_FILE, PREFIX, Settings

# Of the kernel, the tests, the benchmarks, and commands that ask a server.
_NAMES = ("NATIVE", "PROFILE", "SEED", "FACTOR", "SERVER", "API_KEY")
_OTHERS = {CONFIG_FILE} | {f"{PREFIX}{name}" for name in _NAMES}
_OTHER_PREFIXES = (f"{PREFIX}BENCH_", f"{PREFIX}MBM")


def variable_of(name: str) -> str:
    """Return the variable of a setting."""
    return f"{PREFIX}{name.upper()}"


def nearest_setting(name: str) -> str:
    """Return the name of a setting that is most like another one."""
    return get_close_matches(name.lower(), Settings.model_fields, n=1, cutoff=0.0)[0]


def unknown_variables(environment: Mapping[str, str]) -> dict[str, str]:
    """Return the variables that look like settings and are none, each with the nearest that is."""
    return {
        variable: variable_of(nearest_setting(variable.upper().removeprefix(PREFIX)))
        for variable in sorted(environment)
        if _is_unknown(variable.upper())
    }


def sentence_of(variable: str, nearest: str) -> str:
    """Return what is wrong with a variable that is no setting."""
    return f"{variable} is no setting and does nothing; the nearest is {nearest}"


def _is_unknown(variable: str) -> bool:
    if not variable.startswith(PREFIX) or variable.startswith(_OTHER_PREFIXES):
        return False
    return variable not in _OTHERS and variable[len(PREFIX) :].lower() not in Settings.model_fields
