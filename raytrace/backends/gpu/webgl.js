// WebGL2 on a float framebuffer. The page's answers are objects: {rejected: log}, {unavailable: why} or the result.

let gl, programs;

function start() {
    gl = document.createElement("canvas").getContext("webgl2", {antialias: false});
    if (!gl) return {unavailable: "the browser gives no WebGL2 context"};
    if (!gl.getExtension("EXT_color_buffer_float"))
        return {unavailable: "the browser cannot render to floats (EXT_color_buffer_float)"};
    programs = new Map();
    return {};
}

function about() {
    const named = gl.getExtension("WEBGL_debug_renderer_info");
    const renderer = gl.getParameter(named ? named.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
    return `${renderer}; ${gl.getParameter(gl.VERSION)}`;
}

class Rejected extends Error {}

function shader(type, source) {
    const made = gl.createShader(type);
    gl.shaderSource(made, source);
    gl.compileShader(made);
    if (!gl.getShaderParameter(made, gl.COMPILE_STATUS)) throw new Rejected(gl.getShaderInfoLog(made) || "context lost");
    return made;
}

function compiled({vertex, fragment}) {
    const key = vertex + fragment;
    if (!programs.has(key)) {
        const program = gl.createProgram();
        gl.attachShader(program, shader(gl.VERTEX_SHADER, vertex));
        gl.attachShader(program, shader(gl.FRAGMENT_SHADER, fragment));
        gl.linkProgram(program);
        if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Rejected(gl.getProgramInfoLog(program));
        programs.set(key, program);
    }
    return programs.get(key);
}

const TYPES = ["FLOAT", "FLOAT_VEC2", "FLOAT_VEC3", "FLOAT_VEC4", "INT", "INT_VEC2", "INT_VEC3", "INT_VEC4",
    "UNSIGNED_INT", "BOOL", "BOOL_VEC2", "BOOL_VEC3", "BOOL_VEC4", "FLOAT_MAT2", "FLOAT_MAT3", "FLOAT_MAT4",
    "SAMPLER_2D"];

function activeUniforms(program) {
    const made = compiled(program);
    const names = new Map(TYPES.map(name => [gl[name], name]));
    const found = [];
    for (let i = 0; i < gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS); i++) {
        const {name, type, size} = gl.getActiveUniform(made, i);
        found.push([name, names.get(type) ?? `type 0x${type.toString(16)}`, size]);
    }
    return found;
}

function set(program, name, {kind, values}) {
    const place = gl.getUniformLocation(program, name);
    if (place === null) return;
    const setters = {
        float: "uniform1fv", vec2: "uniform2fv", vec3: "uniform3fv", vec4: "uniform4fv",
        int: "uniform1iv", ivec2: "uniform2iv", ivec3: "uniform3iv", ivec4: "uniform4iv",
    };
    if (kind.startsWith("mat")) gl[`uniformMatrix${kind[3]}fv`](place, false, values);
    else gl[setters[kind]](place, values);
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

// Draws one pass after the other; gives the base64 of each one's floats.
async function draw({program, width, height, count, viewport, uniforms, textures, passes}) {
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
    const bound = Object.entries(textures).map(([name, texels], unit) => {
        gl.uniform1i(gl.getUniformLocation(made, name), unit);
        return texture(unit, texels);
    });
    for (const [name, value] of Object.entries(uniforms)) set(made, name, value);
    const images = [];
    for (const changed of passes) {
        for (const [name, value] of Object.entries(changed)) set(made, name, value);
        gl.viewport(...viewport);
        gl.clear(gl.COLOR_BUFFER_BIT);
        gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
        const pixels = new Float32Array(4 * width * count);
        gl.readPixels(0, 0, width, count, gl.RGBA, gl.FLOAT, pixels);
        images.push(await base64(pixels));
    }
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
        if (error instanceof Rejected) return {result: {rejected: error.message}};
        throw error;
    }
}
