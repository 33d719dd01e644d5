// Drives a page as a person does, by its keys and buttons, and writes down what it then shows.
(() => {
  const seen = { errors: [], steps: [], say: "" };
  addEventListener("error", (event) => seen.errors.push(event.message));
  const key = (name, more = {}) => document.body.dispatchEvent(new KeyboardEvent("keydown", { key: name, bubbles: true, ...more }));
  const text = (selector) => document.querySelector(selector)?.textContent ?? "";
  const { cursor, trace, schematic, waveform } = window.discreta;

  // what stands on the screen, not what the program thinks
  const look = () => {
    const rows = {};
    let scope = "";
    for (const item of document.querySelectorAll(".names li")) {
      if (item.className.includes("scope")) scope = item.textContent;
      else rows[`${scope}.${item.querySelector(".name").textContent}`] = item.querySelector(".value").textContent;
    }
    const wires = [...document.querySelectorAll("g.net[data-net]")].flatMap((net) =>
      [...net.querySelectorAll("text.value")].map((label) => [net.dataset.net, net.dataset.bits, label.textContent, net.getAttribute("class")]),
    );
    seen.steps.push({ time: cursor.time, now: text("#now"), rows, wires, say: text("#route .say") });
  };
  // every scope open, and room for every row
  const closed = [...document.querySelectorAll(".scope button[aria-expanded=false]")];
  for (const button of closed.length > 400 ? closed.slice(0, 5) : closed) {
    [...document.querySelectorAll(".scope button")].find((b) => b.textContent === button.textContent).click();
  }
  const large = waveform.rows.length > 1200;
  // a canvas is at most 65,535 pixels high
  if (waveform.rows.length < 2000) {
    document.body.style.overflow = "auto";
    document.getElementById("waveform").style.height = `${waveform.rows.length * 26 + 60}px`;
    waveform.resize();
  }

  key("Home");
  look();
  for (let n = 0; n < trace.times.length && n < (large ? 8 : 400); n++) {
    if (n % 2) key("ArrowRight");
    else document.getElementById("forth").click();
    look();
  }
  key("End");
  look();
  for (let n = 0; n < 5; n++) {
    key("ArrowLeft");
    look();
  }

  // by the changes of one net, found by its name
  const search = document.getElementById("search");
  search.value = "xt";
  search.dispatchEvent(new Event("input"));
  seen.found = cursor.selected?.name ?? "";
  seen.net = text("#net");
  key("Home");
  seen.jumps = [];
  for (let n = 0; n < 6; n++) {
    key("ArrowRight", { shiftKey: true });
    seen.jumps.push(cursor.time);
  }
  key("ArrowLeft", { shiftKey: true });
  seen.jumps.push(cursor.time);
  key("Home");
  seen.edges = [1, 2, 3].map(() => (key("."), cursor.time));

  // all that can be pressed
  for (const name of ["r", "r", "r", "r", "a", "a", "+", "+", "-", "f", "d", "d", "[", "]", "ArrowDown", "ArrowUp", "?", "?"]) key(name);
  for (const button of document.querySelectorAll(".zoom button")) button.click();
  key(" ");
  seen.playing = document.getElementById("play").getAttribute("aria-pressed");
  key(" ");
  seen.stopped = document.getElementById("play").getAttribute("aria-pressed");
  seen.unnamed = [...document.querySelectorAll("button, input, select, canvas[role], [role=img]")]
    .filter((e) => !(e.getAttribute("aria-label") || e.textContent.trim() || e.closest("label")))
    .filter((e) => !e.closest("#route"))
    .map((e) => e.outerHTML.slice(0, 80));
  seen.wires = schematic.wires.length;
  const pre = document.createElement("pre");
  pre.id = "seen";
  pre.textContent = JSON.stringify(seen);
  document.body.append(pre);
  // where several pages are gone through, one after the other
  if (parent !== window) parent.postMessage(pre.textContent, "*");
})();
