"""WAX: drive a real robot from any browser, picture and sound in step."""

__version__ = "0.9.0"
