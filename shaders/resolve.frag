// From linear light to the screen: filmic curve, then sRGB.
uniform sampler2D u_picture;

in vec2 v_place;
out vec4 f_colour;

// Narkowicz' fit of the ACES curve.
vec3 filmic(vec3 x) {
    return clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
}

vec3 to_srgb(vec3 x) {
    return mix(12.92 * x, 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, x));
}

void main() {
    vec3 colour = to_srgb(filmic(texture(u_picture, v_place).rgb));
    // Half a grey level of fixed noise keeps the water's soft gradients from banding.
    float grain = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    f_colour = vec4(colour + (grain - 0.5) / 255.0, 1.0);
}
