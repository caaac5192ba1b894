// The sun's direction as two angles in degrees, as raytrace/scene/sun.py has it.

const degree = Math.PI / 180;

function sunDirection({azimuth, elevation}) {
    const level = Math.cos(elevation * degree);
    const [x, z] = [Math.sin(azimuth * degree), -Math.cos(azimuth * degree)];
    return [level * x, Math.sin(elevation * degree), level * z];
}

function sunAngles(direction) {
    const [x, y, z] = normalize(direction);
    return {azimuth: Math.atan2(x, -z) / degree, elevation: Math.asin(Math.min(Math.max(y, -1), 1)) / degree};
}
