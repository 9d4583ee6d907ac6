// The vessels by WebGL 2: two triangles per segment. One texture holds the segments, another the appearance of each vessel.
// (Instancing would be shorter, but nearly twice as slow in a browser without a graphics card.)
// The segments of a coarse picture, but for one a vessel.
const FEW = 8000;

class GlPainter {
  // Throws when the browser has no WebGL 2.
  constructor(canvas, geometry, hull) {
    this.gl = canvas.getContext("webgl2", { antialias: true, alpha: false, preserveDrawingBuffer: true });
    if (!this.gl) throw new Error("no WebGL 2");
    this.canvas = canvas;
    this.geometry = geometry;
    this.textures = [];
    this.paper = [1, 1, 1];
    this.program = this.link(VERTEX, FRAGMENT);
    this.places = this.uniforms(this.program, ["turn", "centre", "extent", "pixel", "depth", "shift", "paper", "segments", "looks"]);
    this.fill();
    this.sketch = this.half = null;
    this.hull = hull && this.wrap(hull);
  }

  uniforms(program, names) {
    return Object.fromEntries(names.map(n => [n, this.gl.getUniformLocation(program, n)]));
  }

  link(vertex, fragment) {
    const gl = this.gl, program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) throw new Error(gl.getProgramInfoLog(program));
    return program;
  }

  // Each segment: its two ends, whose it is, how far along the vessel it begins.
  fill() {
    const { points, starts } = this.geometry, segments = [];
    for (let item = 0; item + 1 < starts.length; item++) {
      let before = 0;
      const last = Math.max(starts[item + 1] - 1, starts[item] + 1);
      for (let i = starts[item]; i < last; i++) {
        const [p, q] = [4 * i, 4 * Math.min(i + 1, starts[item + 1] - 1)];
        for (const at of [p, q]) segments.push(points[at], points[at + 1], points[at + 2], points[at + 3]);
        segments.push(item, before, 0, 0);
        before += Math.hypot(points[q] - points[p], points[q + 1] - points[p + 1], points[q + 2] - points[p + 2]);
      }
    }
    this.count = segments.length / 12;
    this.texture(0, this.gl.RGBA32F, this.gl.FLOAT, Float32Array, segments);
  }

  // The vessels as flat bands of few segments, which a computer without a graphics card draws ten times as fast, for the most part because
  // they go into a picture of their own, of half the size, in which no edge is smoothed.
  bands() {
    const { gl } = this, { points, starts, vessels } = this.geometry, most = Math.max(Math.floor(FEW / vessels), 1), corners = [], whose = [], triangles = [];
    for (let row = 0; row < vessels; row++) {
      const first = starts[row], steps = Math.max(starts[row + 1] - 1 - first, 0), all = Math.min(steps, most);
      for (let k = 0; k < all; k++) {
        const [p, q] = [k, k + 1].map(at => 4 * (first + Math.round(at * steps / all))), towards = [0, 1, 2].map(axis => points[q + axis] - points[p + axis]), at = whose.length;
        for (const end of [p, q]) for (const side of [-1, 1]) { corners.push(points[end], points[end + 1], points[end + 2], side * points[end + 3], ...towards); whose.push(row); }
        triangles.push(at, at + 1, at + 2, at + 2, at + 1, at + 3);
      }
    }
    const program = this.link(BAND_VERTEX, BAND_FRAGMENT), array = gl.createVertexArray(), colours = gl.createBuffer();
    gl.bindVertexArray(array);
    const bind = (name, size, type, isUnit, stride, offset) => {
      const at = gl.getAttribLocation(program, name);
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, size, type, isUnit, stride, offset);
    };
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, Float32Array.from(corners), gl.STATIC_DRAW);
    bind("place", 4, gl.FLOAT, false, 28, 0);
    bind("towards", 3, gl.FLOAT, false, 28, 16);
    gl.bindBuffer(gl.ARRAY_BUFFER, colours);
    bind("look", 4, gl.UNSIGNED_BYTE, true, 0, 0);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, Uint32Array.from(triangles), gl.STATIC_DRAW);
    gl.bindVertexArray(null);
    return { program, array, colours, whose, count: triangles.length, places: this.uniforms(program, ["turn", "centre", "extent", "pixel", "depth", "shift"]) };
  }

  // A picture of half the size, with the program that shows it.
  small() {
    const { gl } = this, program = this.link(COPY_VERTEX, COPY_FRAGMENT), places = this.uniforms(program, ["small"]), [colour, depth, frame] = [gl.createTexture(), gl.createRenderbuffer(), gl.createFramebuffer()];
    gl.activeTexture(gl.TEXTURE2);
    gl.bindTexture(gl.TEXTURE_2D, colour);
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.LINEAR);
    for (const way of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T]) gl.texParameteri(gl.TEXTURE_2D, way, gl.CLAMP_TO_EDGE);
    return { program, places, colour, depth, frame, size: [0, 0] };
  }

  // The picture is made as large as half the canvas, and drawn into.
  intoSmall() {
    const { gl } = this, size = [this.canvas.width, this.canvas.height].map(length => Math.max(length >> 1, 1)), small = this.half ??= this.small();
    gl.bindFramebuffer(gl.FRAMEBUFFER, small.frame);
    if (small.size.join() !== size.join()) {
      small.size = size;
      gl.activeTexture(gl.TEXTURE2);
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, ...size, 0, gl.RGBA, gl.UNSIGNED_BYTE, null);
      gl.bindRenderbuffer(gl.RENDERBUFFER, small.depth);
      gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT16, ...size);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, small.colour, 0);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, small.depth);
    }
    gl.viewport(0, 0, ...size);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  }

  paintBands(aim, pixel) {
    const { gl } = this, { program, array, colours, whose, count, places } = this.sketch ??= this.bands();
    this.intoSmall();
    gl.useProgram(program);
    aim(places);
    gl.uniform1f(places.pixel, 2 * pixel);
    gl.bindVertexArray(array);
    if (this.sketch.looks !== this.looks) {
      const bytes = new Uint8Array(4 * whose.length);
      whose.forEach((row, at) => bytes.set(this.looks.subarray(4 * row, 4 * row + 4), 4 * at));
      gl.bindBuffer(gl.ARRAY_BUFFER, colours);
      gl.bufferData(gl.ARRAY_BUFFER, bytes, gl.DYNAMIC_DRAW);
      this.sketch.looks = this.looks;
    }
    gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 0);
    gl.bindVertexArray(null);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.viewport(0, 0, this.canvas.width, this.canvas.height);
    gl.disable(gl.DEPTH_TEST);
    gl.useProgram(this.half.program);
    gl.uniform1i(this.half.places.small, 2);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  // The surface around the vessels, ready to be drawn.
  wrap({ places, normals, triangles }) {
    const { gl } = this, program = this.link(HULL_VERTEX, HULL_FRAGMENT), array = gl.createVertexArray();
    gl.bindVertexArray(array);
    const fill = (kind, numbers) => { gl.bindBuffer(kind, gl.createBuffer()); gl.bufferData(kind, numbers, gl.STATIC_DRAW); };
    const bind = (name, numbers, type, isUnit, bytes) => {
      const at = gl.getAttribLocation(program, name);
      fill(gl.ARRAY_BUFFER, numbers);
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, 3, type, isUnit, bytes, 0);
    };
    bind("place", places, gl.FLOAT, false, 12);
    bind("normal", normals, gl.BYTE, true, 4);
    fill(gl.ELEMENT_ARRAY_BUFFER, triangles);
    gl.bindVertexArray(null);
    return { program, array, count: triangles.length, places: this.uniforms(program, ["turn", "centre", "extent", "depth", "shift", "lift", "focus"]) };
  }

  // Red, green, blue and LOOK of every vessel and marker.
  dress(looks) {
    const { gl } = this;
    this.looks = looks.slice();
    this.texture(1, gl.RGBA8, gl.UNSIGNED_BYTE, Uint8Array, looks);
  }

  // Four numbers a dot.
  texture(unit, inside, kind, ArrayOf, numbers) {
    const gl = this.gl, wide = 1536, high = Math.max(1, Math.ceil(numbers.length / 4 / wide));
    const dots = new ArrayOf(4 * wide * high);
    dots.set(numbers);
    gl.activeTexture(gl.TEXTURE0 + unit);
    if (!this.textures[unit]) {
      this.textures[unit] = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, this.textures[unit]);
      for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
    }
    gl.texImage2D(gl.TEXTURE_2D, 0, inside, wide, high, 0, gl.RGBA, kind, dots);
  }

  // `hull`: how the surface is shown; null where it is not. `coarse`: as bands.
  paint(camera, hull, coarse) {
    const gl = this.gl, { width, height } = this.canvas, [w, h] = camera.size;
    gl.viewport(0, 0, width, height);
    gl.clearColor(...this.paper, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.SAMPLE_ALPHA_TO_COVERAGE);
    const aim = places => {
      // Rows of `turn` are columns here: the shader multiplies from the left.
      gl.uniformMatrix3fv(places.turn, false, camera.turn.flat());
      gl.uniform3fv(places.centre, camera.centre);
      gl.uniform2f(places.extent, camera.mm * w / 2, camera.mm * h / 2);
      gl.uniform1f(places.depth, camera.depth * 1.1);
      gl.uniform1f(places.shift, dot(camera.turn[2], camera.middle.map((m, axis) => m - camera.centre[axis])));
    };
    if (coarse) return this.paintBands(aim, camera.mm * w / width);
    gl.useProgram(this.program);
    aim(this.places);
    gl.uniform1f(this.places.pixel, camera.mm * w / width);
    gl.uniform3fv(this.places.paper, this.paper);
    gl.uniform1i(this.places.segments, 0);
    gl.uniform1i(this.places.looks, 1);
    gl.drawArrays(gl.TRIANGLES, 0, 6 * this.count);
    if (this.hull && hull) this.paintHull(aim, hull);
  }

  // Waits until all is drawn.
  finish() {
    this.gl.readPixels(0, 0, 1, 1, this.gl.RGBA, this.gl.UNSIGNED_BYTE, new Uint8Array(4));
  }

  // Two passes: the depth of what is nearest, then its colour over the vessels behind it. So nothing needs an order.
  paintHull(aim, { lift, focus }) {
    const { gl } = this, { program, array, count, places } = this.hull;
    gl.disable(gl.SAMPLE_ALPHA_TO_COVERAGE);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.useProgram(program);
    aim(places);
    gl.uniform1f(places.lift, lift);
    gl.uniform4fv(places.focus, focus);
    gl.bindVertexArray(array);
    gl.colorMask(false, false, false, false);
    gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 0);
    gl.colorMask(true, true, true, true);
    gl.depthFunc(gl.LEQUAL);
    gl.drawElements(gl.TRIANGLES, count, gl.UNSIGNED_INT, 0);
    gl.depthFunc(gl.LESS);
    gl.bindVertexArray(null);
    gl.disable(gl.BLEND);
  }
}
