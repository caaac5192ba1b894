// The shaders on WebGL2: a program for each tone mapper, compiled when it is first wanted.

// Its message is for the page.
class Failure extends Error {}

// Gives the function that draws a step with a tone mapper; `changed` are the uniforms that are not the scene's own.
function startGpu(canvas, scene) {
    // The buffer is kept so that the browser's "Save image" finds the picture.
    const gl = canvas.getContext("webgl2", {alpha: false, antialias: false, preserveDrawingBuffer: true});
    if (!gl) throw new Failure("This browser gives no WebGL2 context. Is hardware acceleration turned off?");
    const names = Object.keys(scene.textures);
    names.forEach((name, unit) => texture(gl, unit, scene.textures[name]));
    const programs = new Map();

    return (mapper, step, changed) => {
        if (gl.isContextLost()) throw new Failure("The graphics context was lost. It may come back; if not, reload.");
        if (!programs.has(mapper)) {
            const made = compiled(gl, scene.vertex, scene.fragments[mapper]);
            gl.useProgram(made);
            setUniforms(gl, made, scene.uniforms);
            names.forEach((name, unit) => gl.uniform1i(gl.getUniformLocation(made, name), unit));
            programs.set(mapper, made);
        }
        const program = programs.get(mapper);
        gl.useProgram(program);
        setUniforms(gl, program, changed);
        gl.uniform1i(gl.getUniformLocation(program, "shownStep"), step);
        gl.viewport(0, 0, canvas.width, canvas.height);
        gl.drawArrays(gl.TRIANGLE_STRIP, 0, 4);
    };
}

function compiled(gl, vertex, fragment) {
    const program = gl.createProgram();
    for (const [type, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
        const shader = gl.createShader(type);
        gl.shaderSource(shader, source);
        gl.compileShader(shader);
        if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS))
            throw new Failure(`The shader does not compile here: ${gl.getShaderInfoLog(shader)}`);
        gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS))
        throw new Failure(`The shader does not link here: ${gl.getProgramInfoLog(program)}`);
    return program;
}

// Floats, vectors and matrices by how many numbers they have; WebGL passes over those that a program does not use.
function setUniforms(gl, program, values) {
    const setters = {
        1: (place, value) => gl.uniform1fv(place, value),
        3: (place, value) => gl.uniform3fv(place, value),
        9: (place, value) => gl.uniformMatrix3fv(place, false, value),
        16: (place, value) => gl.uniformMatrix4fv(place, false, value),
    };
    for (const [name, value] of Object.entries(values))
        setters[value.length](gl.getUniformLocation(program, name), value);
}

function texture(gl, unit, {width, height, texels}) {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER])
        gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
    const bytes = Uint8Array.from(atob(texels), character => character.charCodeAt(0));
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, width, height, 0, gl.RGBA, gl.FLOAT, new Float32Array(bytes.buffer));
}
