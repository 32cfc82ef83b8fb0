"""Questions put to models, and what came of it. It reads datasets and writes results; engines are never touched."""
