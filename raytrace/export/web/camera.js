// The camera: its matrices, as raytrace/uniforms.py computes them, and how it moves. In double precision.

const plus = (a, b) => a.map((x, i) => x + b[i]);
const minus = (a, b) => a.map((x, i) => x - b[i]);
const times = (a, s) => a.map(x => x * s);
const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);
const cross = ([a, b, c], [d, e, f]) => [b * f - c * e, c * d - a * f, a * e - b * d];
// Divided by its largest component first, as any length is allowed.
const normalize = a => {
    const scaled = times(a, 1 / Math.max(...a.map(Math.abs)));
    return times(scaled, 1 / Math.hypot(...scaled));
};

// Rows to columns, and back.
const transposed = rows => rows[0].map((_, i) => rows.map(row => row[i]));

// The uniforms, matrices column by column.
function matrices(camera, aspect) {
    const [ndcToView, viewToWorld] =
        camera.projection === "matrices"
            ? [transposed(camera.ndc_to_view).flat(), transposed(camera.view_to_world).flat()]
            : [inverseProjection(camera, aspect), axes(camera)];
    return {camPos: viewToWorld.slice(12, 15), ndcToView, viewToWorld};
}

function inverseProjection(camera, aspect) {
    const {near, far} = camera;
    if (camera.projection === "orthographic") {
        const half = camera.height / 2;
        return [half * aspect, 0, 0, 0, 0, half, 0, 0, 0, 0, -(far - near) / 2, 0, 0, 0, -(far + near) / 2, 1];
    }
    const half = Math.tan(camera.field_of_view * (Math.PI / 360));
    const product = 2 * near * far;
    return [half * aspect, 0, 0, 0, 0, half, 0, 0, 0, 0, 0, (near - far) / product, 0, 0, -1, (near + far) / product];
}

// Right, up, backward and position.
function axes({position, target, up}) {
    const back = normalize(minus(position, target));
    const right = normalize(cross(normalize(up), back));
    return [...right, 0, ...cross(back, right), 0, ...back, 0, ...position, 1];
}

// `vector` turned about the unit vector `axis` by an angle in radians (Rodrigues).
function turned(vector, axis, angle) {
    const [sine, cosine] = [Math.sin(angle), Math.cos(angle)];
    const along = times(axis, dot(axis, vector) * (1 - cosine));
    return plus(plus(times(vector, cosine), times(cross(axis, vector), sine)), along);
}

const POLE = 0.02; // radians that the camera keeps from looking along up

// The camera after the scene was turned to the right and down, in radians.
function orbited(camera, pivot, right, down) {
    const given = camera.projection === "matrices";
    const up = given ? [0, 1, 0] : normalize(camera.up);
    const back = given ? transposed(camera.view_to_world)[2].slice(0, 3) : minus(camera.position, camera.target);
    const side = cross(up, normalize(back));
    const fromUp = Math.atan2(Math.hypot(...side), dot(up, normalize(back)));
    const [least, most] = [Math.min(POLE, fromUp), Math.max(Math.PI - POLE, fromUp)];
    const tilt = Math.min(Math.max(fromUp - down, least), most) - fromUp;
    const axis = Math.hypot(...side) > 1e-9 ? normalize(side) : [1, 0, 0];
    const turn = vector => turned(turned(vector, axis, tilt), up, -right);
    const around = point => plus(pivot, turn(minus(point, pivot)));
    return given ? withAxes(camera, turn, around) : {...camera, position: around(camera.position)};
}

// The camera after its distance to the pivot, or the height of what it sees, was multiplied by `factor`.
function zoomed(camera, pivot, factor) {
    const nearer = point => plus(pivot, times(minus(point, pivot), factor));
    if (camera.projection === "orthographic") return {...camera, height: camera.height * factor};
    if (camera.projection === "perspective") return {...camera, position: nearer(camera.position)};
    return withAxes(camera, axis => axis, nearer);
}

// Of a camera given by matrices: its axes and its position changed.
function withAxes(camera, ofAxis, ofPosition) {
    const [right, up, back, position] = transposed(camera.view_to_world.slice(0, 3));
    const rows = transposed([ofAxis(right), ofAxis(up), ofAxis(back), ofPosition(position)]);
    return {...camera, view_to_world: [...rows, camera.view_to_world[3]]};
}
