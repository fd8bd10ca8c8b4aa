#include "fish_light.glsl"
// What differs between species; `render/fishes.py` fills it in, in this order.
struct Look {
    vec4 cell;      // where its skin and gutters lie on the atlas: left, bottom, width, height
    vec4 skin_box;  // left, bottom, right, top of the body on its skin, body lengths
    vec4 eye;       // distance from the snout, height, radius, body lengths; of the edge of the
                    // gill cover behind it, 0 if there is none
    vec4 coat;      // gloss; how plainly scales show; how silvery; 1: fins are stiff
    vec4 build;     // length of the recorded fish, cm; where the tail begins, body lengths;
                    // brightness of mating colours; share of fishes with a torn fin
    vec4 vary;      // of individuals: hue, saturation, brightness; pattern, body lengths
    vec4 mouth;     // its tip and its corner: behind the snout, height, body lengths
    vec4 jaws;      // angle of the lower one when wide open, rad, 0 if it does not move; half the
                    // width of the border between them, body lengths; teeth in half the round;
                    // share of fishes with a scar
    vec4 wear;      // a colour that mating changes; 1 / reach²
    vec4 show;      // by how much; times as saturated
    vec4 pectoral;  // cosine and sine of its droop; 1: it is held out like a wing
    vec4 pelvic;
    vec4 rays;      // share of spines in the base of the dorsal and the ventral fin; height of the
                    // tail's edge over the length of the tail, at most 1
    vec4 roots[2];  // from the control point of a right paired fin to its root, body lengths:
                    // of the pectoral and of the pelvic fin
};

layout(std140) uniform Looks {
    Look looks[SPECIES];
    vec4 frames[5];  // left, bottom, width, height, shares of a cell: the fins, as parts are
                     // numbered (dorsal, ventral, pectoral, pelvic), then the body
};

// Column and row of a control point of a recorded frame in their table: blocks of TABLE_ROWS frames
// stand side by side, as drivers limit the height of a texture.
const int CONTROL_POINTS = 426, TABLE_ROWS = 4096;

ivec2 table_place(int point, int frame) {
    return ivec2(point + CONTROL_POINTS * (frame / TABLE_ROWS), frame % TABLE_ROWS);
}
