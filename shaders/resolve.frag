// From linear light to the screen: filmic curve, then sRGB. Where both eyes are on the canvas,
// the left one's picture above the right one's, they are woven together (view/stereo.py). WEAVE is
// defined when this is compiled: a software renderer would walk every branch for every pixel.
// SMOOTH, 0 or 1: whether edges of a plain picture are smoothed.
uniform sampler2D u_picture;
uniform vec2 u_size;    // pixels of the picture
uniform vec2 u_wide;    // angle of a panorama, tilt of a dome, rad
uniform float u_margin; // tangent of half a cube face's angle of view

const int PLAIN = 0, LEFT = 1, RIGHT = 2, ROWS = 3, CHECKERS = 4, RED_CYAN = 5, DUBOIS = 6,
    EQUIRECTANGULAR = 7, DOME = 8, PANORAMA = 9;
const float PI = 3.14159265358979;

// Dubois, "A projection method to generate anaglyph stereo images" (2001), for red-cyan glasses.
const mat3 DUBOIS_LEFT = mat3(
    0.4561, -0.0400822, -0.0152161, 0.500484, -0.0378246, -0.0205971, 0.176381, -0.0157589,
    -0.00546856);
const mat3 DUBOIS_RIGHT = mat3(
    -0.0434706, 0.378476, -0.0721527, -0.0879388, 0.73364, -0.112961, -0.00155529, -0.0184503,
    1.2264);

in vec2 v_place;
out vec4 f_colour;

// Narkowicz' fit of the ACES curve, on each channel and on the strongest. Curving each channel
// would turn saturated colours toward yellow, cyan and magenta; so most of the hue is kept, but of
// what is very bright, which burns out to white.
vec3 filmic(vec3 x) {
    vec4 y = vec4(x, max(max(x.r, x.g), max(x.b, 1e-4)));
    vec4 curved = clamp(y * (2.51 * y + 0.03) / (y * (2.43 * y + 0.59) + 0.14), 0.0, 1.0);
    return mix(curved.rgb, x * (curved.a / y.a), 0.4 - 0.4 * curved.a * curved.a);
}

// The power in it by roots, which processors have, within a third of a grey level (Taylor's fit).
vec3 to_srgb(vec3 x) {
    vec3 a = sqrt(x), b = sqrt(a), c = sqrt(b);
    vec3 bright = 0.662002687 * a + 0.684122060 * b - 0.323583601 * c - 0.0225411470 * x;
    return mix(12.92 * x, bright, step(0.0031308, x));
}

// The pixel of an eye, 0 left or 1 right, at (x, row) from its upper left corner.
vec3 eye(int which, ivec2 place) {
    ivec2 canvas = textureSize(u_picture, 0);
    int top = which == 0 ? canvas.y : canvas.y / 2;
    return filmic(texelFetch(u_picture, ivec2(place.x, top - 1 - place.y), 0).rgb);
}

vec3 woven() {
    ivec2 canvas = textureSize(u_picture, 0);
    int height = WEAVE == ROWS ? canvas.y : canvas.y / 2;
    ivec2 place = ivec2(int(gl_FragCoord.x), height - 1 - int(gl_FragCoord.y));
    if (WEAVE == ROWS)
        return eye(place.y % 2, ivec2(place.x, place.y / 2));
    if (WEAVE == CHECKERS)
        return eye((place.x + place.y) % 2, place);
    if (WEAVE == LEFT || WEAVE == RIGHT)
        return eye(WEAVE - LEFT, place);
    vec3 left = eye(0, place), right = eye(1, place);
    if (WEAVE == RED_CYAN)
        return vec3(left.r, right.gb);
    return clamp(DUBOIS_LEFT * left + DUBOIS_RIGHT * right, 0.0, 1.0);
}

// Where a pixel looks: right, up, ahead (view/surround.py). Zero outside a dome.
vec3 direction() {
    vec2 place = gl_FragCoord.xy / u_size - 0.5;
    if (WEAVE == EQUIRECTANGULAR) {
        float longitude = 2.0 * PI * place.x, latitude = PI * place.y;
        return vec3(sin(longitude) * cos(latitude), sin(latitude), cos(longitude) * cos(latitude));
    }
    if (WEAVE == PANORAMA) {
        float longitude = u_wide.x * place.x;
        return vec3(sin(longitude), u_wide.x * place.y * u_size.y / u_size.x, cos(longitude));
    }
    vec2 p = place * u_size * 2.0 / min(u_size.x, u_size.y);
    float r = length(p);
    if (r > 1.0)
        return vec3(0.0);
    vec2 aside = p / max(r, 1e-6) * sin(0.5 * PI * r);
    float c = cos(u_wide.y), s = sin(u_wide.y);
    return cos(0.5 * PI * r) * vec3(0.0, c, s) + vec3(aside.x, aside.y * s, -aside.y * c);
}

// The cube's faces: left, ahead, right in the lower row, below, astern, above in the upper.
vec3 all_round(vec3 d) {
    vec3 far = abs(d);
    float cell;
    vec3 q;  // along the face's own right and up, and its distance
    if (far.x >= far.y && far.x >= far.z) {
        cell = d.x < 0.0 ? 0.0 : 2.0;
        q = vec3(d.x < 0.0 ? d.z : -d.z, d.y, far.x);
    } else if (far.z >= far.y) {
        cell = d.z > 0.0 ? 1.0 : 4.0;
        q = vec3(d.z > 0.0 ? d.x : -d.x, d.y, far.z);
    } else {
        cell = d.y < 0.0 ? 3.0 : 5.0;
        q = vec3(d.x, d.y < 0.0 ? d.z : -d.z, far.y);
    }
    vec2 inside = 0.5 + 0.5 * q.xy / (q.z * u_margin);
    vec2 corner = vec2(mod(cell, 3.0), floor(cell / 3.0));
    return filmic(texture(u_picture, (corner + inside) / vec2(3.0, 2.0)).rgb);
}

const float HALF = 0.35;  // light that is half as bright as can be, about as the curve has it

// Light as shares of what can be seen, so that a glint weighs no more than its surroundings; and
// about how bright it looks.
vec4 tap(vec2 place) {
    vec3 x = texture(u_picture, place).rgb;
    x /= HALF + max(x.r, max(x.g, x.b));
    return vec4(x, sqrt(dot(x, vec3(0.30, 0.59, 0.11))));
}

// Blends along an edge that its contrast shows (Lottes, "FXAA", 2009, the short form).
vec3 smoothed(vec2 place) {
    vec2 pixel = 1.0 / vec2(textureSize(u_picture, 0));
    vec4 middle = tap(place);
    float a = tap(place + pixel * vec2(-1.0, 1.0)).a, b = tap(place + pixel).a;
    float c = tap(place - pixel).a, d = tap(place + pixel * vec2(1.0, -1.0)).a;
    float least = min(middle.a, min(min(a, b), min(c, d)));
    float most = max(middle.a, max(max(a, b), max(c, d)));
    vec2 along = vec2(c + d - a - b, a + c - b - d);
    float steep = min(abs(along.x), abs(along.y)) + max((a + b + c + d) / 32.0, 1.0 / 128.0);
    along = clamp(along / steep, -8.0, 8.0) * pixel;
    vec4 near = 0.5 * (tap(place - along / 6.0) + tap(place + along / 6.0));
    vec4 far = 0.5 * near + 0.25 * (tap(place - 0.5 * along) + tap(place + 0.5 * along));
    vec3 x = (far.a < least || far.a > most ? near : far).rgb;
    x = most - least < max(0.03, 0.12 * most) ? middle.rgb : x;
    return HALF * x / max(1.0 - max(x.r, max(x.g, x.b)), 1e-3);
}

vec3 light() {
    if (WEAVE == PLAIN)
        return filmic(SMOOTH == 1 ? smoothed(v_place) : texture(u_picture, v_place).rgb);
    if (WEAVE < EQUIRECTANGULAR)
        return woven();
    vec3 d = direction();
    return d == vec3(0.0) ? vec3(0.0) : all_round(d);
}

void main() {
    vec3 colour = to_srgb(light());
    // Half a grey level of fixed noise keeps the water's soft gradients from banding.
    float grain = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    f_colour = vec4(colour + (grain - 0.5) / 255.0, 1.0);
}
