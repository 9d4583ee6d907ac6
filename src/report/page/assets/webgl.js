// The vessels by WebGL 2: one instance a segment, and a texture of one dot a vessel for how it looks.
class GlPainter {
  // Throws when the browser has no WebGL 2.
  constructor(canvas, geometry) {
    this.gl = canvas.getContext("webgl2", { antialias: true, alpha: false, preserveDrawingBuffer: true });
    if (!this.gl) throw new Error("no WebGL 2");
    this.canvas = canvas;
    this.geometry = geometry;
    this.program = this.link();
    this.places = Object.fromEntries(["turn", "centre", "extent", "pixel", "depth", "shift", "looks"].map(n => [n, this.gl.getUniformLocation(this.program, n)]));
    this.fill();
  }

  link() {
    const gl = this.gl, program = gl.createProgram();
    for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
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
        segments.push(item, before);
        before += Math.hypot(points[q] - points[p], points[q + 1] - points[p + 1], points[q + 2] - points[p + 2]);
      }
    }
    const gl = this.gl;
    this.count = segments.length / 10;
    gl.bindVertexArray(gl.createVertexArray());
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(segments), gl.STATIC_DRAW);
    for (const [place, size, offset] of [[0, 4, 0], [1, 4, 16], [2, 2, 32]]) {
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, size, gl.FLOAT, false, 40, offset);
      gl.vertexAttribDivisor(place, 1);
    }
    gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  }

  // Red, green, blue and LOOK of every vessel and marker.
  dress(looks) {
    const gl = this.gl, wide = 1024, high = Math.max(1, Math.ceil(looks.length / 4 / wide));
    const dots = new Uint8Array(4 * wide * high);
    dots.set(looks);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, wide, high, 0, gl.RGBA, gl.UNSIGNED_BYTE, dots);
  }

  paint(camera) {
    const gl = this.gl, { width, height } = this.canvas, [w, h] = camera.size;
    gl.viewport(0, 0, width, height);
    gl.clearColor(1, 1, 1, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.SAMPLE_ALPHA_TO_COVERAGE);
    gl.useProgram(this.program);
    // Rows of `turn` are columns here: the shader multiplies from the left.
    gl.uniformMatrix3fv(this.places.turn, false, camera.turn.flat());
    gl.uniform3fv(this.places.centre, camera.centre);
    gl.uniform2f(this.places.extent, camera.mm * w / 2, camera.mm * h / 2);
    gl.uniform1f(this.places.pixel, camera.mm * w / width);
    gl.uniform1f(this.places.depth, camera.depth * 1.1);
    gl.uniform1f(this.places.shift, dot(camera.turn[2], camera.middle.map((m, axis) => m - camera.centre[axis])));
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, this.count);
  }
}
