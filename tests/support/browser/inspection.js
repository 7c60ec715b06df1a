(() => {
  // A pixel of tolerance: browsers measure text with the font's own bearings.
  const slack = 1;
  const box = (element) => element.getBoundingClientRect();
  const within = (inner, outer) =>
    inner.left >= outer.left - slack && inner.right <= outer.right + slack &&
    inner.top >= outer.top - slack && inner.bottom <= outer.bottom + slack;
  // Boxes of texts are higher than their letters: lines may touch, letters may not.
  const over = (a, b) =>
    Math.min(a.right, b.right) - Math.max(a.left, b.left) > 2 &&
    Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top) > 0.4 * Math.min(a.height, b.height);
  const isCurve = (line) => {
    const points = (line.getAttribute("points") || "").trim().split(/\s+/);
    return points.length > 2 || new Set(points).size > 1;
  };
  const drawing = (svg) => {
    const outer = box(svg);
    const texts = [...svg.querySelectorAll("text")].filter((t) => t.textContent.trim());
    const overlapping = [];
    texts.forEach((a, i) => texts.slice(i + 1).forEach((b) => {
      if (over(box(a), box(b))) overlapping.push(`${a.textContent.trim()} | ${b.textContent.trim()}`);
    }));
    const marks = [...svg.querySelectorAll("polyline, rect, circle, path, line")];
    const attributes = marks.flatMap((mark) => [...mark.attributes]);
    return {
      label: svg.getAttribute("aria-label") || "",
      width: outer.width,
      height: outer.height,
      curves: [...svg.querySelectorAll("polyline")].filter(isCurve).length,
      marks: marks.filter((mark) => box(mark).width + box(mark).height > 0).length,
      cut_off: texts.filter((t) => !within(box(t), outer)).map((t) => t.textContent.trim()),
      overlapping,
      malformed: attributes.filter((a) => /NaN|Infinity|undefined/.test(a.value)).map((a) => a.name),
    };
  };
  const page = document.documentElement;
  const wide = [...document.body.querySelectorAll("h1, h2, p, li, figure, table, .scroll, summary, footer")]
    .filter((element) => box(element).right > page.clientWidth + slack || element.scrollWidth > element.clientWidth + slack);
  return {
    drawings: [...document.querySelectorAll("svg")].map(drawing),
    sticking_out: wide.map((element) => element.textContent.trim().slice(0, 80)),
  };
})()
