// The scene file, with the tables that the page changes written anew.

// Always with a point or an exponent: a float, and the same one when it is read.
function tomlNumber(x) {
    const text = Object.is(x, -0) ? "-0" : String(x);
    return /[.e]/.test(text) ? text : `${text}.0`;
}

function tomlValue(value) {
    if (Array.isArray(value)) return `[${value.map(tomlValue).join(", ")}]`;
    return typeof value === "number" ? tomlNumber(value) : JSON.stringify(value);
}

// `text` with the lines of each table, up to the next empty one, replaced.
function withTables(text, tables) {
    for (const [name, table] of Object.entries(tables)) {
        const lines = Object.entries(table).map(([key, value]) => `${key} = ${tomlValue(value)}\n`);
        text = text.replace(new RegExp(`^\\[${name}\\]\\n(.+\\n)*`, "m"), () => `[${name}]\n${lines.join("")}`);
    }
    return text;
}
