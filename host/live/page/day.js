"use strict";
// The day: asks once a second what is so, and has a button for each key that is taken now.
const token = location.hash.slice(1);
const at = (id) => document.getElementById(id);
let shown = "";

function button(text, keys, question) {
  const b = document.createElement("button");
  b.type = "button";
  b.textContent = text;
  b.className = keys === "\n" ? "strong" : "";
  b.dataset.keys = keys;
  b.onclick = () => { if (!question || confirm(question)) press(keys); };
  return b;
}

async function press(keys) {
  for (const b of document.querySelectorAll("button")) b.disabled = true;
  const answer = await fetch("/day", {
    method: "POST", body: JSON.stringify({ keys }),
    headers: { "Content-Type": "application/json", "X-Matrig-Token": token },
  });
  const told = answer.headers.get("Content-Type").startsWith("application/json") ? await answer.json() : { error: await answer.text() };
  at("said").textContent = told.error || "";
  shown = "";
}

function buttonsOf(day) {
  const has = (key) => day.keys.includes(key), made = [];
  if (has("\n")) made.push(button("Do it: " + day.next, "\n"));
  if (has("s")) made.push(button("Skip it", "sy", "Leave out " + day.next + " for the landing to come?"));
  if (has("a")) made.push(button("Arm", "ay", "Arm for the next landing?"));
  if (has("d")) made.push(button("Disarm", "d", "Disarm? A landing that is recorded ends there."));
  if (has("e")) made.push(button("End the log", "e"));
  if (has("r")) made.push(button("Report", "r"));
  if (has("o")) made.push(button("Fetch the slow log", "o"));
  return made;
}

function row(step, number, keys) {
  const tr = document.createElement("tr");
  const cells = [step.state === "next" ? "\u25b6" : step.state === "done" ? "\u2713" : "", step.step, step.state, step.reason];
  for (const text of cells) tr.insertCell().textContent = text;
  if (keys.includes(String(number))) {
    tr.cells[1].textContent = "";
    tr.cells[1].append(button(step.step, String(number)));
  }
  tr.className = step.state.replace(" ", "-");
  return tr;
}

function show(day) {
  at("source").textContent = day.db + ": " + day.landings_today + (day.landings_today === 1 ? " landing today" : " landings today");
  at("next").textContent = day.busy || day.next;
  at("reason").textContent = day.busy ? "at the terminal" : day.reason;
  at("command").textContent = day.command || "";
  at("tile-next").className = day.busy ? "tile armed" : "tile good";
  at("buttons").replaceChildren(...buttonsOf(day));
  at("steps").tBodies[0].replaceChildren(...day.steps.map((step, i) => row(step, i + 1, day.keys)));
}

async function ask() {
  try {
    const text = await (await fetch("/day.json?token=" + token)).text();
    at("offline").hidden = true;
    if (text !== shown) show(JSON.parse(text));
    shown = text;
  } catch {
    at("offline").textContent = "The day has ended, or this computer is away: matrig day DB goes on where it was.";
    at("offline").hidden = false;
    for (const b of document.querySelectorAll("button")) b.disabled = true;
  }
  setTimeout(ask, 1000);
}
ask();
