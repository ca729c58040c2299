"""Scripts that inspect a displayed page."""

from __future__ import annotations

__all__ = ["COLLISIONS", "COLOURS", "DASHES", "DEAD_LINKS", "OUTSIDE", "SCROLLED", "SMALLEST", "UNFOLD"]

UNFOLD = "document.querySelectorAll('details').forEach(each => each.open = true)"

COLLISIONS = """(() => {
  const found = [];
  for (const svg of document.querySelectorAll('figure>svg')) {
    const frame = svg.getBoundingClientRect();
    const title = svg.querySelector('title').textContent;
    const texts = [...svg.querySelectorAll('text')];
    const boxes = texts.map(text => [text.textContent, text.getBoundingClientRect()]);
    boxes.forEach(([name, box], index) => {
      const outside = box.left < frame.left - 1 || box.right > frame.right + 1;
      if (outside || box.bottom > frame.bottom + 1 || box.top < frame.top - 1)
        found.push(title + ': clipped ' + name);
      for (const [other, that] of boxes.slice(index + 1)) {
        const wide = Math.min(box.right, that.right) - Math.max(box.left, that.left);
        const high = Math.min(box.bottom, that.bottom) - Math.max(box.top, that.top);
        if (wide > 1 && high > 3) found.push(title + ': ' + name + ' over ' + other);
      }
    });
  }
  return found;
})()"""
"""Texts of figures that exceed their frame or overlap."""

OUTSIDE = """(() => {
  const wide = document.documentElement.clientWidth;
  const held = element => element.closest('.wide, svg') !== null;
  return [...document.querySelectorAll('body *')]
    .filter(element => !held(element) && element.getBoundingClientRect().right > wide + 1)
    .map(element => element.tagName + '.' + element.className);
})()"""
"""Elements that exceed the page on the right."""

SCROLLED = """[...document.querySelectorAll('.wide')]
  .filter(frame => frame.scrollWidth > frame.clientWidth + 1)
  .map(frame => frame.textContent.slice(0, 60))"""
"""Tables that require horizontal scrolling."""

SMALLEST = """Math.min(...[...document.querySelectorAll('figure>svg text')].map(text =>
  parseFloat(getComputedStyle(text).fontSize) * text.ownerSVGElement.getScreenCTM().a))"""
"""The size of the smallest text in a figure, px."""

COLOURS = """(() => {
  const style = getComputedStyle(document.documentElement);
  const names = ['paper', 'ink', 'muted', 'soft', 'recorded', 'before', 'after', 'mark'];
  return Object.fromEntries(names.map(name => [name, style.getPropertyValue('--' + name).trim()]));
})()"""
"""The current palette, #rrggbb or #rgb by name."""

DASHES = """Object.fromEntries(['before', 'after', 'recorded'].map(name => {
  const style = getComputedStyle(document.querySelector('#motion figure path.' + name));
  return [name, [style.strokeDasharray, style.strokeWidth]];
}))"""
"""Dashes and widths of lines."""

DEAD_LINKS = """[...document.querySelectorAll('a:not(.data)')].map(link => link.getAttribute('href'))
  .filter(target => !target.startsWith('#') || !document.getElementById(target.slice(1)))"""
"""Links without a target in the page."""

FAINT = """(() => {
  const channels = colour => colour.match(/[\\d.]+/g).map(Number);
  const luminance = colour => channels(colour).slice(0, 3).map(value => value / 255)
    .map(share => share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4)
    .reduce((sum, share, k) => sum + share * [0.2126, 0.7152, 0.0722][k], 0);
  const behind = element => {
    for (let one = element; one; one = one.parentElement) {
      const colour = getComputedStyle(one).backgroundColor;
      if ((channels(colour)[3] ?? 1) > 0) return colour;
    }
    return 'rgb(255, 255, 255)';
  };
  const own = element => [...element.childNodes].some(node => node.nodeType === 3 && node.data.trim());
  return [...document.querySelectorAll('body *')]
    .filter(element => own(element) && element.checkVisibility() && !element.closest('script, .unseen'))
    .map(element => {
      const style = getComputedStyle(element);
      const front = luminance(element.closest('svg') ? style.fill : style.color);
      const [low, high] = [front, luminance(behind(element))].sort((a, b) => a - b);
      return [(high + 0.05) / (low + 0.05), element.tagName, element.textContent.trim().slice(0, 30)];
    }).filter(([ratio]) => ratio < 4.5);
})()"""
"""Texts whose contrast with their background is below that of WCAG AA, 4.5."""
