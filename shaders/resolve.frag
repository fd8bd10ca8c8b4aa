// From linear light to the screen: filmic curve, then sRGB. Where both eyes are on the canvas,
// the left one's picture above the right one's, they are woven together (view/stereo.py).
uniform sampler2D u_picture;
uniform int u_weave;

const int PLAIN = 0, LEFT = 1, RIGHT = 2, ROWS = 3, CHECKERS = 4, RED_CYAN = 5, DUBOIS = 6;

// Dubois, "A projection method to generate anaglyph stereo images" (2001), for red-cyan glasses.
const mat3 DUBOIS_LEFT = mat3(
    0.4561, -0.0400822, -0.0152161, 0.500484, -0.0378246, -0.0205971, 0.176381, -0.0157589,
    -0.00546856);
const mat3 DUBOIS_RIGHT = mat3(
    -0.0434706, 0.378476, -0.0721527, -0.0879388, 0.73364, -0.112961, -0.00155529, -0.0184503,
    1.2264);

in vec2 v_place;
out vec4 f_colour;

// Narkowicz' fit of the ACES curve.
vec3 filmic(vec3 x) {
    return clamp(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0);
}

vec3 to_srgb(vec3 x) {
    return mix(12.92 * x, 1.055 * pow(x, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, x));
}

// The pixel of an eye, 0 left or 1 right, at (x, row) from its upper left corner.
vec3 eye(int which, ivec2 place) {
    ivec2 canvas = textureSize(u_picture, 0);
    int top = which == 0 ? canvas.y : canvas.y / 2;
    return filmic(texelFetch(u_picture, ivec2(place.x, top - 1 - place.y), 0).rgb);
}

vec3 woven() {
    ivec2 canvas = textureSize(u_picture, 0);
    int height = u_weave == ROWS ? canvas.y : canvas.y / 2;
    ivec2 place = ivec2(int(gl_FragCoord.x), height - 1 - int(gl_FragCoord.y));
    if (u_weave == ROWS)
        return eye(place.y % 2, ivec2(place.x, place.y / 2));
    if (u_weave == CHECKERS)
        return eye((place.x + place.y) % 2, place);
    if (u_weave == LEFT || u_weave == RIGHT)
        return eye(u_weave - LEFT, place);
    vec3 left = eye(0, place), right = eye(1, place);
    if (u_weave == RED_CYAN)
        return vec3(left.r, right.gb);
    return clamp(DUBOIS_LEFT * left + DUBOIS_RIGHT * right, 0.0, 1.0);
}

void main() {
    vec3 light = u_weave == PLAIN ? filmic(texture(u_picture, v_place).rgb) : woven();
    vec3 colour = to_srgb(light);
    // Half a grey level of fixed noise keeps the water's soft gradients from banding.
    float grain = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    f_colour = vec4(colour + (grain - 0.5) / 255.0, 1.0);
}
