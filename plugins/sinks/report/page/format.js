'use strict';
// Elements, numbers and times as text.

/** An element with attributes (`on…`: a listener) and children. */
function el(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else if (value === true) element.setAttribute(name, '');
    else if (value !== false && value != null) element.setAttribute(name, value);
  }
  element.append(...children.filter((child) => child != null));
  return element;
}

/** The value of a variable of the style sheet: a colour. */
const color = (name) => getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim();

/** With thin spaces between thousands. */
const whole = (value) => Math.round(value).toString().replace(/\B(?=(\d{3})+$)/g, '\u2009');

/** With so many digits that count, never in powers of ten unless it is tiny. */
function digits(value, count = 3) {
  if (value == null || !Number.isFinite(value)) return '–';
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size < 1e-5) return value.toExponential(1).replace('-', '−');
  const decimals = Math.max(0, count - 1 - Math.floor(Math.log10(size)));
  return (size >= 10000 ? whole(value) : value.toFixed(Math.min(decimals, 9))).replace('-', '−');
}

/** A length in the unit in which it is read best. */
function length(metres, count = 3) {
  if (metres == null || !Number.isFinite(metres)) return ['–', ''];
  if (Math.abs(metres) >= 1000) return [digits(metres / 1000, count), 'km'];
  if (Math.abs(metres) >= 0.1) return [digits(metres, count), 'm'];
  if (Math.abs(metres) >= 0.001) return [digits(metres * 100, count - 1), 'cm'];
  return [digits(metres * 1000, count - 1), 'mm'];
}

/** A value with as many decimals as its σ needs for two digits. */
function withSigma(value, sigma) {
  if (value == null) return '–';
  if (!(sigma > 0)) return value.toFixed(2).replace('-', '−');
  const decimals = Math.min(9, Math.max(0, 1 - Math.floor(Math.log10(sigma))));
  return `${value.toFixed(decimals).replace('-', '−')} ± ${sigma.toFixed(decimals)}`;
}

/** Seconds since the start of the log, as text: 12.3 s, 2:05, 1:02:05. */
function clock(t, decimals = 1) {
  if (t < 60 && t > -60) return `${t.toFixed(decimals).replace('-', '−')} s`;
  const sign = t < 0 ? '−' : '';
  const all = Math.floor(Math.abs(t));
  const two = (n) => String(n).padStart(2, '0');
  const hours = Math.floor(all / 3600);
  const rest = `${hours ? two(Math.floor(all / 60) % 60) : Math.floor(all / 60)}:${two(all % 60)}`;
  return sign + (hours ? `${hours}:${rest}` : rest);
}

/** 1, 2 or 5 times a power of ten, the smallest that is at least `least`. */
function roundStep(least) {
  const power = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 5, 10].map((f) => f * power).find((step) => step >= least * (1 - 1e-9));
}

/** The index of the last element ≤ t of a sorted list; 0 if there is none. */
function indexAt(times, t) {
  let low = 0;
  let high = times.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (times[middle] <= t) low = middle;
    else high = middle - 1;
  }
  return low;
}

/** A name of a state or figure and its unit: "offset_east_m" is ["offset east", "m"]. */
function nameAndUnit(name) {
  const units = [['_mps2', 'm/s²'], ['_radps', 'rad/s'], ['_rad_per_s', 'rad/s'], ['_mps', 'm/s'], ['_per_m', '1/m'], ['_rad', 'rad'],
    ['_deg', '°'], ['_m', 'm'], ['_s', 's'], ['_t', 'T'], ['_ut', 'µT']];
  const found = units.find(([ending]) => name.endsWith(ending));
  const words = (found ? name.slice(0, -found[0].length) : name).replaceAll('_', ' ');
  return [words, found ? found[1] : ''];
}

/** Root of the mean square, largest size and number of the values that are there. */
function statistics(values) {
  let sum = 0;
  let most = 0;
  let count = 0;
  for (const value of values) {
    if (value == null) continue;
    sum += value * value;
    most = Math.max(most, Math.abs(value));
    ++count;
  }
  return { rms: count ? Math.sqrt(sum / count) : null, max: count ? most : null, count };
}
