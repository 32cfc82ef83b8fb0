"""The codeless USD schemas `WmsEpisode`, `WmsAction` and `WmsObservation`; importing this package registers them.

USD reads schemas once per process, when the first stage is opened: import this before, or prims stay untyped. This is
the only import of wmspec that changes process-wide state. The reader does not depend on it, because it uses type names
and knows the fallbacks.
"""

from pathlib import Path

from pxr import Plug

from wmspec.sim.usd.version import FORMAT_VERSION as FORMAT_VERSION

Plug.Registry().RegisterPlugins(str(Path(__file__).parent))
