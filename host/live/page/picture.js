'use strict';
/* Marks in a picture, in its own pixels; matrig computes the height from them and records it. */
(() => {
  const $ = (id) => document.getElementById(id), svg = $('picture'), form = $('form'), image = new Image(), marks = [];
  const make = (tag, attributes, text) => {
    const e = svg.appendChild(document.createElementNS('http://www.w3.org/2000/svg', tag));
    for (const name in attributes) e.setAttribute(name, attributes[name]);
    e.textContent = text || '';
  };
  const draw = () => {
    svg.replaceChildren();
    make('image', { href: '/picture', width: image.naturalWidth, height: image.naturalHeight });
    if (marks[0] && marks[1]) make('path', { d: `M${marks[0]}L${marks[1]}` });
    marks.forEach(([x, y], i) => {
      make('path', { d: `M${x - 9} ${y}h18M${x} ${y - 9}v18` });
      make('text', { x: x + 6, y: y - 8 }, 'ABC'[i]);
    });
  };
  image.onload = () => {
    svg.setAttribute('width', image.naturalWidth);
    svg.setAttribute('height', image.naturalHeight);
    draw();
  };
  image.src = '/picture';
  svg.onclick = (e) => {
    const box = svg.getBoundingClientRect(), at = Number(form.at.value);
    marks[at] = [Math.round(e.clientX - box.left), Math.round(e.clientY - box.top)];
    if (!marks[at + 1] && at < 2) form.at.value = at + 1;
    draw();
  };
  form.onsubmit = async (e) => {
    e.preventDefault();
    const text = `${$('distance').value}: ${marks.map((m) => m.join(',')).join(' ')} ${$('error').value}`;
    const reply = await fetch('/command', { method: 'POST', headers: { 'Content-Type': 'application/json', 'X-Matrig-Token': location.hash.slice(1) }, body: JSON.stringify({ marks: text }) })
      .then((r) => r.json()).catch(() => ({ error: 'matrig refuses or does not answer; open the address that it printed' }));
    $('said').textContent = reply.error || `Height ${reply.height_ft.toFixed(4)} ± ${reply.height_ft_error.toFixed(4)} ft, recorded`;
  };
})();
