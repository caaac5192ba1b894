// The page: a view of the scene, what changes it, and what shows it.

const element = id => document.getElementById(id);
const scene = JSON.parse(element("scene").textContent);
const [stage, canvas] = [element("stage"), element("canvas")];

let view, gpu, waiting;

// As the scene file has it: a value stays exactly as it is until its control is used.
function reset() {
    view = {...structuredClone({camera: scene.camera, sun: scene.sun, film: scene.film}), zoom: 1};
    view.angles = sunAngles(view.sun.direction);
    view.sunDirection = scene.uniforms.sunDirection;
    changed();
}

function turnSun(angles) {
    view.angles = {...view.angles, ...angles};
    view.sun.direction = view.sunDirection = sunDirection(view.angles);
}

// Each slider: its value, what moving it does, and its value in words.
const degrees = x => `${x.toFixed(1)}°`;
const SLIDERS = {
    azimuth: [() => view.angles.azimuth, azimuth => turnSun({azimuth}), degrees],
    elevation: [() => view.angles.elevation, elevation => turnSun({elevation}), degrees],
    fov: [() => view.camera.field_of_view, x => { view.camera.field_of_view = x; }, degrees],
    exposure: [() => view.film.exposure, x => { view.film.exposure = x; }, x => `${x.toFixed(2)} EV`],
};
// What stands for the field of view where there is none.
const OTHER_FOV = {
    orthographic: () => `none: height ${view.camera.height.toPrecision(4)}`,
    matrices: () => "by its matrices",
};

function draw() {
    waiting = false;
    const {camera, sunDirection, film} = view;
    const exposureFactor = [2 ** film.exposure];
    const uniforms = {...matrices(camera, canvas.width / canvas.height), sunDirection, exposureFactor};
    let failure = "";
    try {
        gpu ??= startGpu(canvas, scene);
        gpu(film.tone_mapper, element("step").selectedIndex, uniforms);
    } catch (error) {
        if (!(error instanceof Failure)) throw error;
        failure = error.message;
    }
    tell(failure);
    show();
}

function tell(failure) {
    element("message").textContent = failure;
    element("message").hidden = !failure;
    canvas.classList.toggle("failed", Boolean(failure));
}

function show() {
    for (const [id, [read, , words]] of Object.entries(SLIDERS)) {
        const other = id === "fov" && OTHER_FOV[view.camera.projection];
        if (!other) element(id).value = read();
        document.querySelector(`output[for=${id}]`).textContent = other ? other() : words(read());
    }
    element("mapper").value = view.film.tone_mapper;
    element("told").textContent = `${element("step").value}: ${scene.steps[element("step").value]}.`;
    const command = `raytrace render view.toml --size ${canvas.width}x${canvas.height}`;
    element("command").textContent = command;
    const {camera, sun, film} = view;
    element("toml").value = `# ${command}\n${withTables(scene.toml, {camera, sun, film})}`;
}

function changed() {
    element("status").textContent = "";
    if (!waiting) requestAnimationFrame(draw);
    waiting = true;
}

function orbit(right, down) {
    view.camera = orbited(view.camera, scene.pivot, right, down);
    changed();
}

function zoom(factor) {
    const wanted = Math.min(Math.max(view.zoom * factor, 1e-3), 1e3);
    view.camera = zoomed(view.camera, scene.pivot, wanted / view.zoom);
    view.zoom = wanted;
    changed();
}

async function copy() {
    if (waiting) draw();
    try {
        await navigator.clipboard.writeText(element("toml").value);
        element("status").textContent = "Copied.";
    } catch {
        element("details").open = true;
        element("toml").focus();
        element("toml").select();
        element("status").textContent = "The clipboard is refused here: the text is selected, copy it yourself.";
    }
}

gestures(canvas, orbit, zoom);

canvas.addEventListener("webglcontextlost", event => {
    event.preventDefault(); // or it would never be restored
    changed();
});
canvas.addEventListener("webglcontextrestored", () => {
    gpu = undefined;
    changed();
});

// As large as fits, one pixel of the canvas for each of the screen's.
function fit() {
    const [wide, high] = scene.size;
    const {width, height} = stage.getBoundingClientRect();
    const room = Math.min(width, (height * wide) / high) * devicePixelRatio;
    canvas.width = Math.max(1, Math.floor(room + 0.01)); // it may be a rounding below a whole number
    canvas.height = Math.max(1, Math.round((canvas.width * high) / wide));
    canvas.style.width = `${canvas.width / devicePixelRatio}px`;
    canvas.style.height = `${canvas.height / devicePixelRatio}px`;
    draw(); // at once: a canvas of a new size is empty
}

for (const [id, [, write]] of Object.entries(SLIDERS)) {
    element(id).addEventListener("input", event => {
        write(event.target.valueAsNumber);
        changed();
    });
}
element("mapper").addEventListener("change", event => {
    view.film.tone_mapper = event.target.value;
    changed();
});
element("step").addEventListener("change", changed);
element("copy").addEventListener("click", copy);
element("controls").addEventListener("reset", event => {
    event.preventDefault();
    element("step").value = "display";
    reset();
});
element("controls").addEventListener("submit", event => event.preventDefault());

stage.style.setProperty("--aspect", scene.size[0] / scene.size[1]);
element("mapper").append(...Object.keys(scene.fragments).map(name => new Option(name)));
element("step").append(...Object.keys(scene.steps).map(name => new Option(name)));
element("step").value = "display";
reset();
new ResizeObserver(fit).observe(stage);
addEventListener("resize", fit); // or only the size of the screen's pixels has changed
// A scene may lie beyond a slider's usual ends.
for (const id of ["fov", "exposure"]) {
    const slider = element(id);
    const value = SLIDERS[id][0]() ?? slider.value;
    slider.min = Math.min(slider.min, value);
    slider.max = Math.max(slider.max, value);
}
element("fov").disabled = scene.camera.projection !== "perspective";
