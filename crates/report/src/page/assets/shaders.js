// Each segment of a vessel is a tapered tube with a ball at each end. A rectangle around it is drawn, and every pixel computes
// the exact surface (after Quilez, round cone).
const LOOK = { hidden: 1, pruned: 2, undecided: 4, picked: 8, marker: 16, inlet: 32, faint: 64, top: 128 };

const VERTEX = `#version 300 es
precision highp float;
uniform sampler2D segments;           // three dots each: the two ends (x, y, z and radius, mm), then vessel and mm along it so far
uniform mat3 turn;
uniform vec3 centre;
uniform vec2 extent;                  // half of the view, mm
uniform float pixel;                  // mm
uniform sampler2D looks;
flat out vec3 a, axis;
flat out vec2 radii;
flat out float before;
flat out vec4 look;
out vec2 place;
vec4 dot_of(int at) {
  int wide = textureSize(segments, 0).x;
  return texelFetch(segments, ivec2(at % wide, at / wide), 0);
}
void main() {
  int segment = gl_VertexID / 6, nth = gl_VertexID % 6;
  vec4 first = dot_of(3 * segment), second = dot_of(3 * segment + 1), whose = dot_of(3 * segment + 2);
  vec2 corner = vec2(nth == 1 || nth > 3, nth == 2 || nth == 3 || nth == 5);
  int vessel = int(whose.x + 0.5), wide = textureSize(looks, 0).x;
  look = texelFetch(looks, ivec2(vessel % wide, vessel / wide), 0);
  int state = int(look.a * 255.0 + 0.5);
  if ((state & 1) != 0) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
  a = (first.xyz - centre) * turn;
  vec3 b = (second.xyz - centre) * turn;
  axis = b - a;
  before = whose.y;
  bool pruned = (state & 2) != 0;
  radii = max(vec2(first.w, second.w) * (pruned ? 0.55 : 1.0), (pruned ? 0.7 : 1.0) * pixel);
  if ((state & 16) != 0) radii = (state & 32) != 0 ? max(1.5 * radii, 4.0 * pixel) : max(1.35 * radii, 2.4 * pixel);
  if ((state & 8) != 0) radii += 2.5 * pixel;
  float flat_length = length(axis.xy);
  vec2 forth = flat_length > 1e-6 * pixel ? axis.xy / flat_length : vec2(1.0, 0.0);
  float reach = max(radii.x, radii.y) + pixel;
  place = (corner.x < 0.5 ? -forth * reach : axis.xy + forth * reach) + vec2(-forth.y, forth.x) * reach * (2.0 * corner.y - 1.0);
  gl_Position = vec4((a.xy + place) / extent, 0.0, 1.0);
}`;

const FRAGMENT = `#version 300 es
precision highp float;
uniform float pixel, depth, shift;
uniform vec3 paper;
flat in vec3 a, axis;
flat in vec2 radii;
flat in float before;
flat in vec4 look;
in vec2 place;
out vec4 ink;
const vec3 LIGHT = normalize(vec3(-0.35, 0.55, 0.76));
const vec3 DARK = vec3(0.1);
void main() {
  int state = int(look.a * 255.0 + 0.5);
  // Along the ray, from the reader: the highest of the two balls and the tube between them.
  float slope = radii.x - radii.y, whole = dot(axis, axis), off = dot(axis.xy, place), from = dot(place, place);
  float height = -1e30, share = 0.0;
  vec3 normal = vec3(0.0);
  for (int end = 0; end < 2; end++) {
    vec3 ball = float(end) * axis;
    float r = radii[end], under = r * r - dot(place - ball.xy, place - ball.xy);
    if (under < 0.0 || ball.z + sqrt(under) < height) continue;
    height = ball.z + sqrt(under);
    share = float(end);
    normal = (vec3(place, height) - ball) / r;
  }
  float inner = whole - slope * slope, across = inner - axis.z * axis.z;
  if (across > 1e-6 * whole) {
    float middle = axis.z * (off - slope * radii.x);
    float under = middle * middle - across * (inner * from - off * off + 2.0 * off * slope * radii.x - whole * radii.x * radii.x);
    if (under >= 0.0) {
      float top = (middle + sqrt(under)) / across, y = off - radii.x * slope + top * axis.z;
      if (y > 0.0 && y < inner && top > height) {
        height = top;
        share = y / inner;
        normal = normalize(inner * vec3(place, top) - axis * y);
      }
    }
  }
  if (height < -1e29) discard;
  float along = before + share * sqrt(whole);
  if ((state & 2) != 0 && (state & 8) == 0 && fract(along / (9.0 * pixel)) > 0.58) discard;
  // Half of the light comes from everywhere, more from above; the rim is a little darker, so that vessels stand apart.
  float light = 0.74 + 0.08 * normal.y + 0.30 * max(dot(normal, LIGHT), 0.0);
  float shine = 0.10 * pow(max(dot(reflect(-LIGHT, normal), vec3(0.0, 0.0, 1.0)), 0.0), 24.0);
  vec3 colour = look.rgb;
  if ((state & 4) != 0 && fract(along / (12.0 * pixel)) > 0.7) colour = DARK;
  if ((state & 8) != 0 && normal.z < 0.7) colour = DARK;
  colour = colour * light * mix(0.6, 1.0, smoothstep(0.0, 0.45, normal.z)) + shine;
  float deep = clamp(0.5 - 0.5 * (a.z + height - shift) / depth, 0.0, 1.0);
  if ((state & 8) == 0) colour = mix(colour, paper, 0.35 * smoothstep(0.4, 0.9, deep));
  if ((state & 64) != 0) colour = mix(colour, paper, 0.82);
  // What is selected, and cuts, which lie inside of vessels, are never hidden.
  gl_FragDepth = (state & (8 | 128)) != 0 ? 0.01 * deep : 0.02 + 0.98 * deep;
  // How far inside of the outline the pixel lies, whichever way the tube points.
  float flat_length = length(axis.xy);
  vec2 forth = flat_length > 1e-6 * pixel ? axis.xy / flat_length : vec2(1.0, 0.0);
  float part = dot(place, forth);
  float inside = max(radii.x - length(place), radii.y - length(place - axis.xy));
  if (part > 0.0 && part < flat_length) inside = max(inside, mix(radii.x, radii.y, part / flat_length) - abs(dot(place, vec2(-forth.y, forth.x))));
  ink = vec4(colour, clamp(inside / pixel + 0.5, 0.0, 1.0));
}`;

// While a slow picture moves: bands that face the reader, darker at the rims.
const BAND_VERTEX = `#version 300 es
precision highp float;
uniform mat3 turn;
uniform vec3 centre;
uniform vec2 extent;
uniform float pixel, depth, shift;    // mm
in vec4 place;                        // mm, and the radius, below zero on the one side
in vec3 towards;
in vec4 look;
out vec4 band;
void main() {
  int state = int(look.a * 255.0 + 0.5);
  if ((state & 1) != 0) { gl_Position = vec4(2.0, 2.0, 2.0, 1.0); return; }
  vec3 at = (place.xyz - centre) * turn;
  vec2 d = (towards * turn).xy;
  float size = length(d), wide = max(abs(place.w) * ((state & 2) != 0 ? 0.55 : 1.0), pixel) + ((state & 8) != 0 ? 2.5 * pixel : 0.0);
  if (size > 0.0) at.xy += sign(place.w) * wide * vec2(-d.y, d.x) / size;
  float deep = clamp(0.5 - 0.5 * (at.z - shift) / depth, 0.0, 1.0);
  band = vec4((state & 64) != 0 ? mix(look.rgb, vec3(1.0), 0.82) : look.rgb, sign(place.w));
  gl_Position = vec4(at.xy / extent, 2.0 * ((state & 8) != 0 ? 0.01 * deep : 0.02 + 0.98 * deep) - 1.0, 1.0);
}`;
const BAND_FRAGMENT = `#version 300 es
precision mediump float;
in vec4 band;
out vec4 ink;
void main() { ink = vec4(band.rgb * (1.0 - 0.4 * band.a * band.a), 1.0); }`;

// One triangle that covers the view, with a picture.
const COPY_VERTEX = `#version 300 es
out vec2 at;
void main() {
  at = vec2(gl_VertexID == 1 ? 2.0 : 0.0, gl_VertexID == 2 ? 2.0 : 0.0);
  gl_Position = vec4(2.0 * at - 1.0, 0.0, 1.0);
}`;
const COPY_FRAGMENT = `#version 300 es
precision mediump float;
uniform sampler2D small;
in vec2 at;
out vec4 ink;
void main() { ink = vec4(texture(small, at).rgb, 1.0); }`;

// The surface of the segmentation looks like glass: clear where it faces the reader, denser at its rims. Far from a place in focus it nearly disappears.
const HULL_VERTEX = `#version 300 es
precision highp float;
uniform mat3 turn;
uniform vec3 centre;
uniform vec2 extent;
uniform float depth, shift, lift;     // mm; lift: towards the reader, so that tubes as wide as the vessel do not come through
uniform vec4 focus;                   // a place and how far around it the surface stays, mm; everywhere without
in vec3 place, normal;
out vec3 facing;
out float deep, away;
void main() {
  vec3 at = (place - centre) * turn;
  facing = normal * turn;
  deep = clamp(0.5 - 0.5 * (at.z + lift - shift) / depth, 0.0, 1.0);
  away = focus.w > 0.0 ? smoothstep(1.0, 1.8, distance(place, focus.xyz) / focus.w) : 0.0;
  gl_Position = vec4(at.xy / extent, 2.0 * (0.02 + 0.98 * deep) - 1.0, 1.0);
}`;
const HULL_FRAGMENT = `#version 300 es
precision highp float;
in vec3 facing;
in float deep, away;
out vec4 ink;
const vec3 LIGHT = normalize(vec3(-0.35, 0.55, 0.76));
void main() {
  vec3 n = normalize(facing);
  if (n.z < 0.0) n = -n;
  float rim = 1.0 - n.z, light = 0.72 + 0.08 * n.y + 0.30 * max(dot(n, LIGHT), 0.0);
  float part = mix(0.16, 0.62, rim * rim) * (1.0 - 0.35 * smoothstep(0.4, 0.9, deep)) * (1.0 - 0.8 * away);
  ink = vec4(vec3(0.80, 0.55, 0.47) * light, part);
}`;
