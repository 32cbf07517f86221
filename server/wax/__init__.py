"""WAX: drive a real robot from any browser, picture and sound in step."""

__version__ = "1.0.0"
