// Mouse, touch and keys on the canvas: `orbit` is given angles to the right and down, `zoom` a factor of distance.

function gestures(canvas, orbit, zoom) {
    // Where each pointer was last: one turns the scene, two zoom.
    const pointers = new Map();
    const spread = () => {
        const [[ax, ay], [bx, by]] = pointers.values();
        return Math.hypot(ax - bx, ay - by);
    };

    canvas.addEventListener("pointerdown", event => {
        if (event.button !== 0) return;
        canvas.setPointerCapture(event.pointerId);
        pointers.set(event.pointerId, [event.clientX, event.clientY]);
    });
    canvas.addEventListener("pointermove", event => {
        if (!pointers.has(event.pointerId)) return;
        const [x, y] = pointers.get(event.pointerId);
        const before = pointers.size === 2 && spread();
        pointers.set(event.pointerId, [event.clientX, event.clientY]);
        const angle = Math.PI / canvas.clientHeight; // half a turn for the canvas's height
        if (pointers.size === 1) orbit((event.clientX - x) * angle, (event.clientY - y) * angle);
        else if (before && spread()) zoom(before / spread());
    });
    for (const type of ["pointerup", "pointercancel", "lostpointercapture"])
        canvas.addEventListener(type, event => pointers.delete(event.pointerId));

    const turnWheel = event => {
        event.preventDefault();
        // A line is about 16 pixels; a touchpad's pinch comes with the control key and in small steps.
        const pixels = event.deltaY * (event.deltaMode ? 16 : event.ctrlKey ? 8 : 1);
        zoom(Math.exp(pixels / 800));
    };
    canvas.addEventListener("wheel", turnWheel, {passive: false});

    const keys = {
        ArrowLeft: () => orbit(-0.05, 0),
        ArrowRight: () => orbit(0.05, 0),
        ArrowUp: () => orbit(0, -0.05),
        ArrowDown: () => orbit(0, 0.05),
        "+": () => zoom(1 / 1.1),
        "=": () => zoom(1 / 1.1),
        "-": () => zoom(1.1),
    };
    canvas.addEventListener("keydown", event => {
        if (!(event.key in keys) || event.ctrlKey || event.metaKey || event.altKey) return;
        event.preventDefault();
        keys[event.key]();
    });
}
