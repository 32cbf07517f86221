"""How the server looks from outside, for whoever watches over many: metrics and readiness."""
