// WebGL2 on a float framebuffer. The page's answers are objects: {rejected: log, stage}, {unavailable: why} or the result.

let gl, programs;

// The vertices of the picture, for GLSL ES 1.00, which does not count them.
const CORNERS = new Float32Array([0, 0, 1, 0, 0, 1, 1, 1]);

function start() {
    gl = document.createElement("canvas").getContext("webgl2", {antialias: false});
    if (!gl) return {unavailable: "the browser gives no WebGL2 context"};
    if (!gl.getExtension("EXT_color_buffer_float"))
        return {unavailable: "the browser cannot render to floats (EXT_color_buffer_float)"};
    programs = new Map();
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, CORNERS, gl.STATIC_DRAW);
    return {};
}

function about() {
    const named = gl.getExtension("WEBGL_debug_renderer_info");
    const renderer = gl.getParameter(named ? named.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
    return `${renderer}; ${gl.getParameter(gl.VERSION)}`;
}

class Rejected extends Error {
    constructor(log, stage) {
        super(log);
        this.stage = stage;
    }
}

function shader(type, source) {
    const stage = type === gl.VERTEX_SHADER ? "vertex" : "fragment";
    const made = gl.createShader(type);
    gl.shaderSource(made, source);
    gl.compileShader(made);
    if (!gl.getShaderParameter(made, gl.COMPILE_STATUS)) throw new Rejected(gl.getShaderInfoLog(made) || "context lost", stage);
    return made;
}

function compiled({vertex, fragment}) {
    const key = vertex + fragment;
    if (!programs.has(key)) {
        const program = gl.createProgram();
        // The fragment shader first: what is wrong in both is said of its lines.
        gl.attachShader(program, shader(gl.FRAGMENT_SHADER, fragment));
        gl.attachShader(program, shader(gl.VERTEX_SHADER, vertex));
        gl.bindAttribLocation(program, 0, "corner");
        gl.linkProgram(program);
        if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Rejected(gl.getProgramInfoLog(program), "link");
        programs.set(key, program);
    }
    return programs.get(key);
}

const SETTERS = {
    FLOAT: "uniform1fv", FLOAT_VEC2: "uniform2fv", FLOAT_VEC3: "uniform3fv", FLOAT_VEC4: "uniform4fv",
    INT: "uniform1iv", INT_VEC2: "uniform2iv", INT_VEC3: "uniform3iv", INT_VEC4: "uniform4iv",
    BOOL: "uniform1iv", BOOL_VEC2: "uniform2iv", BOOL_VEC3: "uniform3iv", BOOL_VEC4: "uniform4iv",
    UNSIGNED_INT: "uniform1uiv", SAMPLER_2D: "uniform1iv",
    FLOAT_MAT2: "uniformMatrix2fv", FLOAT_MAT3: "uniformMatrix3fv", FLOAT_MAT4: "uniformMatrix4fv",
};

// Name, type and length of each uniform that the program uses; of an array the name without [0].
function uniformsOf(program) {
    const names = new Map(Object.keys(SETTERS).map(name => [gl[name], name]));
    const found = [];
    for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); i++) {
        const {name, type, size} = gl.getActiveUniform(program, i);
        found.push([name.replace(/\[0\]$/, ""), names.get(type) ?? `type 0x${type.toString(16)}`, size]);
    }
    return found;
}

function activeUniforms(program) {
    const made = compiled(program);
    if (gl.getProgramParameter(made, gl.ACTIVE_UNIFORM_BLOCKS)) {
        const name = gl.getActiveUniformBlockName(made, 0);
        throw new Rejected(`error: block ${name}: takes its numbers from a buffer; use uniforms`, "link");
    }
    return uniformsOf(made);
}

function setUniforms(program, pairs) {
    const values = new Map(pairs);
    for (const [name, type] of uniformsOf(program)) {
        if (!values.has(name)) continue;
        const place = gl.getUniformLocation(program, name);
        if (type.startsWith("FLOAT_MAT")) gl[SETTERS[type]](place, false, values.get(name));
        else gl[SETTERS[type]](place, values.get(name));
    }
}

function texture(unit, {width, height, texels}) {
    const made = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, made);
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER])
        gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
    const bytes = Uint8Array.from(atob(texels), character => character.charCodeAt(0));
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, width, height, 0, gl.RGBA, gl.FLOAT, new Float32Array(bytes.buffer));
    return made;
}

// A shader that never writes its colour, as one that only discards, may not be drawn into a buffer of colours.
function drawQuad() {
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    const error = gl.getError();
    if (error === gl.NO_ERROR) return;
    if (error !== gl.INVALID_OPERATION) throw new Error(`WebGL's error 0x${error.toString(16)}`);
    gl.drawBuffers([gl.NONE]);
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    gl.drawBuffers([gl.COLOR_ATTACHMENT0]);
}

// Draws one pass after the other; gives the base64 of each one's floats.
async function draw({program, width, height, count, viewport, box, alpha, uniforms, textures, passes}) {
    const limit = Math.min(...gl.getParameter(gl.MAX_VIEWPORT_DIMS), gl.getParameter(gl.MAX_RENDERBUFFER_SIZE));
    if (width > limit || height > limit)
        return {unavailable: `draws at most ${limit}x${limit} pixels, found ${width}x${height}`};
    const made = compiled(program);
    gl.useProgram(made);
    const target = gl.createRenderbuffer();
    gl.bindRenderbuffer(gl.RENDERBUFFER, target);
    gl.renderbufferStorage(gl.RENDERBUFFER, gl.RGBA32F, width, count);
    const framebuffer = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.RENDERBUFFER, target);
    const bound = textures.map(([name, texels], unit) => {
        gl.uniform1i(gl.getUniformLocation(made, name), unit);
        return texture(unit, texels);
    });
    setUniforms(made, uniforms);
    const attributes = gl.getAttribLocation(made, "corner") === 0;
    if (attributes) {
        gl.enableVertexAttribArray(0);
        gl.vertexAttribPointer(0, 2, gl.FLOAT, false, 0, 0);
    }
    gl.clearColor(0, 0, 0, alpha);
    const images = [];
    for (const changed of passes) {
        setUniforms(made, changed);
        gl.viewport(...viewport);
        gl.clear(gl.COLOR_BUFFER_BIT);
        gl.scissor(...box);
        gl.enable(gl.SCISSOR_TEST);
        drawQuad();
        gl.disable(gl.SCISSOR_TEST);
        const pixels = new Float32Array(4 * width * count);
        gl.readPixels(0, 0, width, count, gl.RGBA, gl.FLOAT, pixels);
        images.push(await base64(pixels));
    }
    if (attributes) gl.disableVertexAttribArray(0);
    for (const each of bound) gl.deleteTexture(each);
    gl.deleteFramebuffer(framebuffer);
    gl.deleteRenderbuffer(target);
    if (gl.isContextLost()) return {lost: true};
    const error = gl.getError();
    return error ? {unavailable: `WebGL's error 0x${error.toString(16)}`} : {images};
}

function base64(array) {
    return new Promise((resolve, reject) => {
        const reader = new FileReader();
        reader.onload = () => resolve(reader.result.slice(reader.result.indexOf(",") + 1));
        reader.onerror = () => reject(reader.error);
        reader.readAsDataURL(new Blob([array]));
    });
}

async function answer(method, argument) {
    try {
        return {result: await {start, about, activeUniforms, draw}[method](argument)};
    } catch (error) {
        if (gl?.isContextLost()) return {result: {lost: true}};
        if (error instanceof Rejected) return {result: {rejected: error.message, stage: error.stage}};
        throw error;
    }
}
