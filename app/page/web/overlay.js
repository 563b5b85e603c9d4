// What is drawn over the picture: hands, forces, fingers and pins.

const kNamespace = 'http://www.w3.org/2000/svg';
const kSpoken = 1500;  // ms between two announcements

const kPrefixes = [[1e6, 'M'], [1e3, 'k'], [1, ''], [1e-3, 'm'], [1e-6, 'µ']];

/** A quantity with three digits and a prefix: 12.3 mN. */
export function quantity(value, unit) {
  const size = Math.abs(value);
  if (!(size > 0)) return `0 ${unit}`;
  const [scale, prefix] = kPrefixes.find(([least]) => size >= 0.9995 * least) ?? kPrefixes.at(-1);
  const digits = Number((value / scale).toPrecision(3));
  return `${Math.abs(digits) >= 1000 ? Math.round(digits) : digits} ${prefix}${unit}`;
}

/** An SVG over the stage; coordinates are CSS pixels from its top left corner. */
export class Overlay {
  constructor(svg, announcer) {
    this.svg = svg;
    this.announcer = announcer;
    this.spoken = -Infinity;
    this.marks = [];
  }

  /** Shows these marks in place of the last ones: {kind: 'line' | 'ring' | 'dot' | 'label', class, ...}. */
  show(marks) {
    if (!marks.length && !this.marks.length) return;
    this.marks = marks;
    this.svg.replaceChildren(...marks.map((mark) => this.#draw(mark)));
  }

  #draw({kind, text, className, ...numbers}) {
    const tag = {line: 'line', ring: 'circle', dot: 'circle', label: 'text'}[kind];
    const node = document.createElementNS(kNamespace, tag);
    for (const [name, value] of Object.entries(numbers)) node.setAttribute(name, value.toFixed(1));
    node.setAttribute('class', className ?? kind);
    if (text !== undefined) node.textContent = text;
    return node;
  }

  /** Says a text to screen readers, not too often. */
  say(text) {
    const now = performance.now();
    if (now - this.spoken < kSpoken || this.announcer.textContent === text) return;
    this.spoken = now;
    this.announcer.textContent = text;
  }
}
