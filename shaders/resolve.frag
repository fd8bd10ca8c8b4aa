// From linear light to the screen: filmic curve, then sRGB. A patch of the canvas comes to its place
// in the picture (view/rig.py): as it is, through a mesh, or out of the faces of a cube; where two
// eyes share its pixels, they are woven together. Defined when this is compiled, as a software
// renderer would walk every branch for every pixel:
//   WEAVE   how two eyes share pixels        SMOOTH  1: edges of a plain picture are smoothed
//   SHAPE   what a pixel shows               MASKED  1: blended with its neighbours, 2: light is added
//   MESH    1: a mesh says of which place
//   GRADED  1: light is developed as the scenario's grade says
//   BLOOM   1: light spreads around what is very bright
//   EXACT   1: each pixel of the place is one of the canvas
//   LINEAR  1: the canvas holds light; 0: it holds what is to be shown, as a test pattern does
//   ADJUSTED  1: colours are weakened, and it is dark beyond the edge mask
#include "curve.glsl"

uniform sampler2D u_picture;
uniform sampler2D u_mask;
uniform vec2 u_size;    // pixels of the output
uniform vec4 u_left;    // the same on the canvas, of the left eye ...
uniform vec4 u_right;   // ... and of the right one
uniform vec2 u_shown;   // pixels of the place, were it not squeezed
uniform vec3 u_wide;    // angle of a panorama, tilt and angle of a dome, rad
uniform float u_apart;  // of a cube: half the eyes' separation over the distance of the screen
uniform float u_gamma;  // of the projector
uniform float u_margin; // tangent of half a cube face's angle of view
uniform float u_whole;  // what the canvas holds is the light over this
uniform ivec2 u_shift;  // pixels from the place to the canvas, where EXACT

uniform sampler2D u_bloom;
uniform vec3 u_tone;    // factors on the values of red, green and blue
uniform vec2 u_edge[32];  // corners of the edge mask, pixels of the output
uniform int u_edges;    // how many; 0: no mask
uniform float u_soft;   // pixels of the fade across its edge

const float SPREAD = 0.5;   // share of the light that is too bright
const int PLAIN = 0, ROWS = 1, CHECKERS = 2, RED_CYAN = 3, DUBOIS = 4;
const int FLAT = 0, WARPED = 1, EQUIRECTANGULAR = 2, DOME = 3, PANORAMA = 4;
const float PI = 3.14159265358979;

// Dubois, "A projection method to generate anaglyph stereo images" (2001), for red-cyan glasses.
const mat3 DUBOIS_LEFT = mat3(
    0.4561, -0.0400822, -0.0152161, 0.500484, -0.0378246, -0.0205971, 0.176381, -0.0157589,
    -0.00546856);
const mat3 DUBOIS_RIGHT = mat3(
    -0.0434706, 0.378476, -0.0721527, -0.0879388, 0.73364, -0.112961, -0.00155529, -0.0184503,
    1.2264);

in vec2 v_place;  // share of the place
in vec4 v_seen;   // of a mesh: shares of the left eye's and the right eye's source
out vec4 f_colour;

// The power in it by roots, which processors have, within a third of a grey level (Taylor's fit).
vec3 to_srgb(vec3 x) {
    vec3 a = sqrt(x), b = sqrt(a), c = sqrt(b);
    vec3 bright = 0.662002687 * a + 0.684122060 * b - 0.323583601 * c - 0.0225411470 * x;
    return mix(12.92 * x, bright, step(0.0031308, x));
}

// What the canvas holds at a place in its own pixels, not mixed with what lies beside the source.
vec3 held(vec4 source, vec2 inside) {
    vec2 place = source.xy + clamp(inside, vec2(0.5), source.zw - 0.5);
    return u_whole * texture(u_picture, place / vec2(textureSize(u_picture, 0))).rgb;
}

// The pixel of an eye for this one of the picture, exactly, counted from the upper left corner.
vec3 pixel(vec4 source) {
    vec2 place = floor(vec2(v_place.x, 1.0 - v_place.y) * source.zw);
    place = source.xy + vec2(place.x, source.w - 1.0 - place.y);
    return u_whole * texelFetch(u_picture, ivec2(place), 0).rgb;
}

// Where a pixel looks: right, up, ahead (view/surround.py). Zero outside a dome.
vec3 direction() {
    vec2 place = (MESH == 1 ? v_seen.xy : v_place) - 0.5;
    if (SHAPE == EQUIRECTANGULAR) {
        float longitude = 2.0 * PI * place.x, latitude = PI * place.y;
        return vec3(sin(longitude) * cos(latitude), sin(latitude), cos(longitude) * cos(latitude));
    }
    if (SHAPE == PANORAMA) {
        float longitude = u_wide.x * place.x;
        return vec3(sin(longitude), u_wide.x * place.y * u_shown.y / u_shown.x, cos(longitude));
    }
    vec2 p = place * u_shown * 2.0 / min(u_shown.x, u_shown.y);
    float r = length(p);
    if (r > 1.0)
        return vec3(0.0);
    float away = 0.5 * u_wide.z * r;
    vec2 aside = p / max(r, 1e-6) * sin(away);
    float c = cos(u_wide.y), s = sin(u_wide.y);
    return cos(away) * vec3(0.0, c, s) + vec3(aside.x, aside.y * s, -aside.y * c);
}

// The cube's faces: left, ahead, right in the lower row, below, astern, above in the upper.
vec3 all_round(vec3 d, vec4 source) {
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
    return curved(held(source, (corner + inside) / vec2(3.0, 2.0) * source.zw));
}

// What an eye, -1 left or 1 right, sees where this pixel lies on the screen.
vec3 eye(vec4 source, vec2 seen, float side) {
    if (SHAPE >= EQUIRECTANGULAR) {
        vec3 d = direction();
        return d == vec3(0.0) ? vec3(0.0) : all_round(d - vec3(side * u_apart, 0.0, 0.0), source);
    }
    return curved(SHAPE == WARPED ? held(source, seen * source.zw) : pixel(source));
}

vec3 woven() {
    if (WEAVE == ROWS || WEAVE == CHECKERS) {
        int turn = int(u_size.y) - 1 - int(gl_FragCoord.y);
        if (WEAVE == CHECKERS)
            turn += int(gl_FragCoord.x);
        bool right = turn % 2 == 1;
        return eye(right ? u_right : u_left, right ? v_seen.zw : v_seen.xy, right ? 1.0 : -1.0);
    }
    vec3 left = eye(u_left, v_seen.xy, -1.0), right = eye(u_right, v_seen.zw, 1.0);
    if (WEAVE == RED_CYAN)
        return vec3(left.r, right.gb);
    return clamp(DUBOIS_LEFT * left + DUBOIS_RIGHT * right, 0.0, 1.0);
}

const float HALF = 0.35;  // light that is half as bright as can be, about as the curve has it

// Light as shares of what can be seen, so that a glint weighs no more than its surroundings; and
// about how bright it looks.
vec4 tap(vec2 place) {
    vec3 x = held(u_left, place);
    x /= HALF + max(x.r, max(x.g, x.b));
    return vec4(x, sqrt(dot(x, vec3(0.30, 0.59, 0.11))));
}

// Blends along an edge that its contrast shows (Lottes, "FXAA", 2009, the short form).
vec3 smoothed(vec2 place) {
    vec4 middle = tap(place);
    float a = tap(place + vec2(-1.0, 1.0)).a, b = tap(place + 1.0).a;
    float c = tap(place - 1.0).a, d = tap(place + vec2(1.0, -1.0)).a;
    float least = min(middle.a, min(min(a, b), min(c, d)));
    float most = max(middle.a, max(max(a, b), max(c, d)));
    vec2 along = vec2(c + d - a - b, a + c - b - d);
    float steep = min(abs(along.x), abs(along.y)) + max((a + b + c + d) / 32.0, 1.0 / 128.0);
    along = clamp(along / steep, -8.0, 8.0);
    vec4 near = 0.5 * (tap(place - along / 6.0) + tap(place + along / 6.0));
    vec4 far = 0.5 * near + 0.25 * (tap(place - 0.5 * along) + tap(place + 0.5 * along));
    vec3 x = (far.a < least || far.a > most ? near : far).rgb;
    x = most - least < max(0.03, 0.12 * most) ? middle.rgb : x;
    return HALF * x / max(1.0 - max(x.r, max(x.g, x.b)), 1e-3);
}

vec3 light() {
    if (WEAVE != PLAIN)
        return woven();
    if (SHAPE >= EQUIRECTANGULAR)
        return eye(u_left, v_seen.xy, -1.0);
    vec2 place = SHAPE == WARPED ? v_seen.xy : v_place, inside = place * u_left.zw;
    vec3 x;
    if (EXACT == 1) x = u_whole * texelFetch(u_picture, ivec2(gl_FragCoord.xy) + u_shift, 0).rgb;
    else x = SMOOTH == 1 ? smoothed(inside) : held(u_left, inside);
    if (BLOOM == 1)
        x += SPREAD * texture(u_bloom, place).rgb;
    return curved(x);
}

// The share of the light that the edge mask lets through at a pixel, by its distance from the edge.
float let_through(vec2 pixel) {
    float nearest = 1e12;
    bool inside = false;
    for (int k = 0; k < u_edges; ++k) {
        vec2 a = u_edge[k], b = u_edge[k == 0 ? u_edges - 1 : k - 1];
        vec2 along = b - a, from = pixel - a;
        vec2 away = from - along * clamp(dot(from, along) / max(dot(along, along), 1e-6), 0.0, 1.0);
        nearest = min(nearest, dot(away, away));
        if ((a.y > pixel.y) != (b.y > pixel.y)
            && pixel.x < a.x + (pixel.y - a.y) * (b.x - a.x) / (b.y - a.y))
            inside = !inside;
    }
    float distance = inside ? sqrt(nearest) : -sqrt(nearest);
    return clamp(0.5 + distance / u_soft, 0.0, 1.0);
}

void main() {
    vec3 colour = LINEAR == 1 ? to_srgb(light()) : light();
    if (ADJUSTED == 1)
        colour *= u_tone;
    if (MASKED >= 1) {
        vec4 mask = texture(u_mask, v_place);
        colour *= mask.rgb;
        if (MASKED == 2)
            colour = pow(pow(colour, vec3(u_gamma)) + mask.a, vec3(1.0 / u_gamma));
    }
    if (ADJUSTED == 1 && u_edges > 0)
        colour *= pow(let_through(gl_FragCoord.xy), 1.0 / u_gamma);
    // Half a grey level of fixed noise keeps the water's soft gradients from banding.
    float grain = fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715))));
    f_colour = vec4(colour + (grain - 0.5) / 255.0, 1.0);
}
