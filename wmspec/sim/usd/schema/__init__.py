"""The codeless USD schemas `WmsEpisode`, `WmsAction` and `WmsObservation`; importing this registers them.

USD reads its schemas once in a process, when the first stage is opened: import this before that, or they stay untyped.
That is why this import, alone in wmspec, changes what the whole process shares: who opens a stage calls none of it.
The reader does not mind, since it goes by type names and knows the fallbacks itself.
"""

from pathlib import Path

from pxr import Plug

from wmspec.sim.usd.version import FORMAT_VERSION as FORMAT_VERSION

Plug.Registry().RegisterPlugins(str(Path(__file__).parent))
