"""What a viewer is at present, by which the permissions decide."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from wax.access.permissions import Role
    from wax.control.loop import ControlLoop
    from wax.control.turns import Turns
    from wax.session.viewer import Viewer


def role_of(viewer: Viewer, turns: Turns, control: ControlLoop) -> Role:
    """Return a viewer's current role."""
    if viewer.visitor.is_embed:
        return "embed"
    if viewer.visitor.is_host:
        return "host"
    if viewer.number != turns.operator:
        return "observer"
    return "adviser" if control.is_taken else "operator"
