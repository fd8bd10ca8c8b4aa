// From linear light to what is shown, before its encoding: the grade of a scenario, and a filmic
// curve. Defined when this is compiled: GRADED, LINEAR as in `resolve.frag`.
uniform vec3 u_gain;         // of a grade
uniform float u_contrast;    // its power
uniform float u_saturation;

const float MIDDLE = 0.18;  // the grey that contrast leaves as it is

// Narkowicz' fit of the ACES curve, on each channel and on the strongest. Curving each channel
// would turn saturated colours toward yellow, cyan and magenta; so most of the hue is kept, but of
// what is very bright, which burns out to white.
vec3 filmic(vec3 x) {
    vec4 y = vec4(x, max(max(x.r, x.g), x.b));
    vec4 steep = (2.51 * y + 0.03) / (y * (2.43 * y + 0.59) + 0.14);  // the curve over its light
    float most = min(y.a * steep.a, 1.0);
    return min(x * mix(steep.rgb, steep.aaa, 0.4 - 0.4 * most * most), 1.0);
}

// Developed as a grade says, about a middle grey.
vec3 graded(vec3 x) {
    x *= u_gain;
    x = max(mix(vec3(dot(x, vec3(0.2126, 0.7152, 0.0722))), x, u_saturation), 0.0);
    return MIDDLE * pow(x / MIDDLE, vec3(u_contrast));
}

vec3 curved(vec3 light) {
    return LINEAR == 1 ? filmic(GRADED == 1 ? graded(light) : light) : light;
}
