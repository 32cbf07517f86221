// One gamepad, in the place of all that the browser knows.
() => {
    const pads = [null];
    const told = (type) => window.dispatchEvent(new Event(type));
    navigator.getGamepads = () => pads;
    window.waxPad = {
        plug({ id = "Test pad", mapping = "standard", buttons = 17 }) {
            pads[0] = {
                index: 0, id, connected: true, mapping,
                timestamp: performance.now(), axes: [0, 0, 0, 0],
                buttons: Array.from({ length: buttons }, () => ({ pressed: false, value: 0 })),
            };
            told("gamepadconnected");
        },
        push(axis, value) { pads[0].axes[axis] = value; },
        press(button, on) { pads[0].buttons[button] = { pressed: on, value: on ? 1 : 0 }; },
    };
}
