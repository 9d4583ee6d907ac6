// What the image shows along a doubtful vessel: straightened from end to end, and across it at a third and two thirds of the way.
const imageCuts = new Map(data.image_cuts.of.map(cut => [cut.vessel, cut]));

function greys(values, width, height, scale, label) {
  const canvas = make("canvas", { width, height, role: "img", "aria-label": label, style: `width: ${width * scale[0]}px; height: ${height * scale[1]}px` });
  const pen = canvas.getContext("2d"), image = pen.createImageData(width, height);
  values.forEach((grey, i) => image.data.set([grey, grey, grey, 255], 4 * i));
  pen.putImageData(image, 0, 0);
  return canvas;
}

// The pictures of a vessel; null where there is none.
function imageOf(row) {
  const cut = imageCuts.get(row);
  if (!cut) return null;
  const { along, across } = data.image_cuts, values = decoded("u8", cut.pixels);
  const [length, width] = cut.size_mm, pixel = 60 / across;
  const part = (from, count) => values.subarray(from, from + count);
  const stretch = Math.min(Math.max(length / width * across / along, 0.6), 2) * pixel;
  const square = at => part(across * along + at * across * across, across * across);
  return make("figure", { class: "image-cuts" },
    greys(part(0, across * along), along, across, [stretch, pixel], "The image along this vessel, straightened"),
    greys(square(0), across, across, [pixel, pixel], "The image across this vessel at a third of the way"),
    greys(square(1), across, across, [pixel, pixel], "The image across this vessel at two thirds of the way"),
    make("figcaption", { text: `The image along this vessel (${shown(length, 3)} mm by ${shown(width, 3)} mm, with what comes before and after it), and across it at ⅓ and ⅔.` }));
}
