// The surface of the segmentation: the faces between voxels inside and outside, smoothed. Corners of voxels move together with their
// neighbours, forth and back so that nothing shrinks (Taubin 1995), and never further than to the middle of a voxel nearby (Gibson 1998).
const SMOOTH = 0.5, BACK = -0.53, PASSES = 8, ROOM = 0.45;

// The voxels inside, a byte for each of the box.
function voxelsOf({ shape, runs }) {
  const bytes = decoded("u8", runs), inside = new Uint8Array(shape[0] * shape[1] * shape[2]);
  for (let at = 0, place = 0, is = 0; at < bytes.length; is = 1 - is) {
    let length = 0;
    for (let shift = 0; ; shift += 7) {
      length += (bytes[at] & 127) * 2 ** shift;
      if (bytes[at++] < 128) break;
    }
    if (is) inside.fill(1, place, place + length);
    place += length;
  }
  return inside;
}

// The surface: `places` and `normals` of its corners (mm), and triangles of three corners.
function surfaceOf(source) {
  const inside = voxelsOf(source), [nx, ny] = source.shape, steps = [1, nx, nx * ny];
  const numbers = new Map(), corners = [], faces = [];
  const corner = place => {
    let number = numbers.get(place);
    if (number === undefined) { number = corners.length; numbers.set(place, number); corners.push(place); }
    return number;
  };
  for (let place = inside.indexOf(1); place >= 0; place = inside.indexOf(1, place + 1)) {
    for (let axis = 0; axis < 3; axis++) {
      const [u, v] = [steps[(axis + 1) % 3], steps[(axis + 2) % 3]];
      if (!inside[place + steps[axis]]) { const at = place + steps[axis]; faces.push(corner(at), corner(at + u), corner(at + u + v), corner(at + v)); }
      if (!inside[place - steps[axis]]) faces.push(corner(place), corner(place + v), corner(place + u + v), corner(place + u));
    }
  }
  // In voxels; a corner of a voxel lies half a voxel before its middle.
  const start = Float32Array.from({ length: 3 * corners.length }, (_, i) => {
    const place = corners[Math.floor(i / 3)], axis = i % 3;
    return (axis === 0 ? place % nx : axis === 1 ? Math.floor(place / nx) % ny : Math.floor(place / steps[2])) - 0.5;
  });
  const at = smoothedCorners(start, faces), places = new Float32Array(at.length), triangles = new Uint32Array(faces.length * 3 / 2);
  for (let i = 0; i < at.length; i += 3) {
    source.affine.forEach((row, k) => { places[i + k] = row[0] * at[i] + row[1] * at[i + 1] + row[2] * at[i + 2] + row[3]; });
  }
  for (let i = 0, to = 0; i < faces.length; i += 4) for (const nth of [0, 1, 2, 0, 2, 3]) triangles[to++] = faces[i + nth];
  return { places, normals: normalsOf(places, triangles), triangles };
}

function smoothedCorners(start, faces) {
  const at = start.slice(), sum = new Float32Array(start.length), count = new Uint8Array(start.length / 3);
  for (let i = 0; i < faces.length; i++) count[faces[i]] += 2;
  for (let pass = 0; pass < 2 * PASSES; pass++) {
    sum.fill(0);
    for (let i = 0; i < faces.length; i++) {
      // The corners before and after it around the face.
      const mine = 3 * faces[i], first = i & ~3, next = 3 * faces[first + (i + 1 & 3)], last = 3 * faces[first + (i + 3 & 3)];
      for (let k = 0; k < 3; k++) sum[mine + k] += at[next + k] + at[last + k];
    }
    const share = pass % 2 === 0 ? SMOOTH : BACK;
    for (let i = 0; i < at.length; i++) {
      const x = at[i] + share * (sum[i] / count[Math.floor(i / 3)] - at[i]);
      at[i] = Math.min(Math.max(x, start[i] - ROOM), start[i] + ROOM);
    }
  }
  return at;
}

// Of each corner the mean of the triangles around it by their areas, as bytes from -127 to 127; four a corner.
function normalsOf(places, triangles) {
  const sum = new Float32Array(places.length), normals = new Int8Array(places.length / 3 * 4);
  for (let i = 0; i < triangles.length; i += 3) {
    const [a, b, c] = [3 * triangles[i], 3 * triangles[i + 1], 3 * triangles[i + 2]];
    for (let k = 0; k < 3; k++) {
      const [l, m] = [(k + 1) % 3, (k + 2) % 3];
      const n = (places[b + l] - places[a + l]) * (places[c + m] - places[a + m]) - (places[b + m] - places[a + m]) * (places[c + l] - places[a + l]);
      sum[a + k] += n; sum[b + k] += n; sum[c + k] += n;
    }
  }
  for (let i = 0; 3 * i < sum.length; i++) {
    const length = Math.hypot(sum[3 * i], sum[3 * i + 1], sum[3 * i + 2]) || 1;
    for (let k = 0; k < 3; k++) normals[4 * i + k] = Math.round(127 * sum[3 * i + k] / length);
  }
  return normals;
}
