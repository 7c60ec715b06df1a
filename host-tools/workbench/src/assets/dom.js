// Elements and numbers.

/** An element with properties, listeners (`onclick`), and children; nothing of it is parsed as HTML. */
export function h(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === undefined || value === null || (value === false && !name.startsWith('aria-'))) continue;
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else if (name === 'style') Object.assign(element.style, value);
    else if (name === 'value') element.value = value;
    else element.setAttribute(name, value === true && !name.startsWith('aria-') ? '' : value);
  }
  element.append(...children.flat(Infinity).filter((child) => child || child === ''));
  return element;
}

export const byId = (id) => document.getElementById(id);

/** Puts children in the place of what an element has. */
export const fill = (id, ...children) => byId(id).replaceChildren(...children.flat(Infinity).filter(Boolean));

/** A number with so many significant digits, without an exponent where people do not want one. */
export function significant(value, digits = 3) {
  if (value === null || value === undefined || !Number.isFinite(value)) return '–';
  const size = Math.abs(value);
  if (size !== 0 && (size >= 1e6 || size < 1e-4)) return value.toExponential(digits - 1);
  const text = value.toPrecision(digits);
  return (text.includes('e') ? String(Math.round(value)) : text).replace('-', '−');
}

export const percent = (share) => `${significant(100 * share, share < 0.0995 ? 1 : 2)} %`;

export const words = (name) => name.replaceAll('_', ' ');

/** Small values in the unit that engineers say: mm, ms, mrad. */
export function scaled(unit) {
  const thousandth = { m: 'mm', 'm/s': 'mm/s', s: 'ms', rad: 'mrad', 'rad/s': 'mrad/s' };
  return thousandth[unit] ? { factor: 1000, unit: thousandth[unit] } : { factor: 1, unit };
}

/** A value with its unit, as engineers say it. */
export function quantity(value, unit) {
  const { factor, unit: said } = scaled(unit);
  return `${significant(factor * value)}${said === '-' || said === '1' ? '' : ` ${said}`}`;
}

/** Says what went wrong, on top of the page; nothing takes it away. */
export function trouble(text) {
  byId('trouble').hidden = !text;
  byId('trouble').textContent = text ?? '';
}
