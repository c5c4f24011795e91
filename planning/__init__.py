"""Motion planning with proofs: load a world, plan, check, solve IK, certify.

`__init__.pyi` lists the public names. Each is imported when it is first used, so that
`import planning` loads no engine (Drake, OMPL, toppra, ruckig).
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
