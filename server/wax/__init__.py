"""WAX: drive a real robot from any browser, picture and sound in step."""

from importlib.metadata import version

__version__ = version("wax-teleop")
