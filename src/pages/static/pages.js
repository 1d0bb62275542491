// What the pages gain with scripts: times in the viewer's zone, pictures to point at and to zoom. Nothing is only here.
"use strict";
(() => {
  const two = (n) => String(n).padStart(2, "0");
  const local = (at) =>
    `${at.getFullYear()}-${two(at.getMonth() + 1)}-${two(at.getDate())} ${two(at.getHours())}:${two(at.getMinutes())}`;

  // What a local time is counted in: UTC+8.
  const zone = (at) => {
    const minutes = -at.getTimezoneOffset();
    const size = Math.abs(minutes);
    return `UTC${minutes < 0 ? "-" : "+"}${Math.floor(size / 60)}${size % 60 ? `:${two(size % 60)}` : ""}`;
  };
  const inHead = document.getElementById("zone");
  if (inHead && new Date().getTimezoneOffset()) inHead.textContent = zone(new Date());

  // "/" leads to the search, unless something is being written.
  document.addEventListener("keydown", (event) => {
    const find = document.getElementById("find");
    if (event.key !== "/" || event.ctrlKey || event.metaKey || event.altKey || !find) return;
    if (event.target.closest("input, textarea, select, [contenteditable]")) return;
    event.preventDefault();
    find.focus();
    find.select();
  });
  const localTimes = (root) => {
    for (const time of root.querySelectorAll("time[datetime]")) {
      const at = new Date(time.dateTime);
      if (isNaN(at) || !at.getTimezoneOffset()) continue;
      time.title = time.textContent;
      time.textContent = "day" in time.dataset ? local(at).slice(0, 10) : `${local(at)} ${zone(at)}`;
    }
  };
  localTimes(document);

  // Days in sentences are counted in UTC; where the viewer's are not, they say so.
  const utcDays = (root) => {
    if (!new Date().getTimezoneOffset()) return;
    const walker = document.createTreeWalker(root, NodeFilter.SHOW_TEXT);
    while (walker.nextNode()) {
      const node = walker.currentNode;
      if (node.parentElement.closest("time, code, pre, textarea, script, option, svg, [translate=no]")) continue;
      node.data = node.data.replace(/\b\d{4}-\d\d-\d\d\b(?!T| \d\d:| UTC)/g, "$& UTC");
    }
  };
  utcDays(document.querySelector("main"));

  // A time that is typed without its zone is of the viewer's.
  document.addEventListener("submit", ({ target }) => {
    for (const input of target.querySelectorAll("input[data-time]")) {
      const [, day, clock = "00:00"] = /^\s*(\d{4}-\d\d-\d\d)(?:[ T](\d\d:\d\d(?::\d\d)?))?\s*$/.exec(input.value) || [];
      const at = new Date(`${day}T${clock}`);
      if (day && !isNaN(at)) input.value = at.toISOString();
    }
  });

  // Up and down among the links that head the lines of a list, once one of them has the focus.
  document.addEventListener("keydown", (event) => {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    const heads = [...document.querySelectorAll("main tbody th a, .alerted header strong a")];
    const here = heads.indexOf(event.target);
    if (!step || here < 0 || event.ctrlKey || event.metaKey || event.altKey || event.shiftKey) return;
    event.preventDefault();
    heads[Math.min(Math.max(here + step, 0), heads.length - 1)].focus();
  });

  // Pictures: which point is meant, by pointer or by keyboard, and which stretch of time is asked for.
  const SVG = "http://www.w3.org/2000/svg";
  const pick = (picture) => {
    const points = [...picture.querySelectorAll("a.point")];
    const area = picture.querySelector("svg.area");
    const said = picture.parentElement.querySelector(".said");
    const place = (point) => {
      const { cx, cy } = point.querySelector("circle");
      return [cx.baseVal.value, cy.baseVal.value];
    };
    let here = -1;
    const show = (k) => {
      if (points[here]) points[here].classList.remove("here");
      here = k;
      if (points[k]) points[k].classList.add("here");
      said.textContent = points[k] ? points[k].querySelector("title").textContent : "";
    };
    const at = (event) => {
      const box = area.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    picture.addEventListener("keydown", (event) => {
      const last = points.length - 1;
      const to = {
        ArrowLeft: here < 0 ? last : Math.max(0, here - 1), ArrowRight: Math.min(last, here + 1), Home: 0, End: last, Escape: -1,
      }[event.key];
      if (to !== undefined) {
        show(to);
        event.preventDefault();
      } else if (event.key === "Enter" && points[here] && points[here].href.baseVal) {
        location.assign(points[here].href.baseVal);
      }
    });
    picture.addEventListener("pointermove", (event) => {
      const [x, y] = at(event);
      const away = (k) => Math.hypot(place(points[k])[0] - x, place(points[k])[1] - y);
      const nearest = points.reduce((best, _, k) => (best < 0 || away(k) < away(best) ? k : best), -1);
      show(nearest >= 0 && away(nearest) < 40 ? nearest : -1);
    });
    picture.addEventListener("pointerleave", () => show(-1));
    if (!picture.closest("#history")) return;

    const [from, until] = [Number(picture.dataset.from), Number(picture.dataset.until)];
    let start = null, brush = null, dragged = false;
    picture.addEventListener("pointerdown", (event) => {
      if (event.button !== 0 || event.pointerType === "touch") return;
      [start] = at(event);
      dragged = false;
    });
    picture.addEventListener("dragstart", (event) => event.preventDefault());
    picture.addEventListener("pointermove", (event) => {
      if (start === null) return;
      const [x] = at(event);
      if (!brush && Math.abs(x - start) > 6) {
        brush = document.createElementNS(SVG, "rect");
        brush.setAttribute("class", "brush");
        brush.setAttribute("height", area.height.baseVal.value);
        area.append(brush);
        picture.setPointerCapture(event.pointerId);
      }
      if (!brush) return;
      dragged = true;
      brush.setAttribute("x", Math.min(x, start));
      brush.setAttribute("width", Math.abs(x - start));
    });
    picture.addEventListener("pointerup", (event) => {
      if (brush) {
        const whole = area.getBoundingClientRect().width;
        const ends = [start, at(event)[0]].sort((a, b) => a - b).map((x) => from + (Math.min(Math.max(x / whole, 0), 1)) * (until - from));
        const coarse = ends[1] - ends[0] > 10 * 864e5;
        const written = ends.map((t) => new Date(t).toISOString()).map((t) => (coarse ? t.slice(0, 10) : `${t.slice(0, 19)}Z`));
        look({ from: written[0], to: written[1] });
        brush.remove();
      }
      start = brush = null;
    });
    picture.addEventListener("click", (event) => { if (dragged) event.preventDefault(); }, true);
    picture.addEventListener("dblclick", () => look({ from: null, to: null }));
  };

  // The same page with another stretch of time, axis or method: only its pictures are exchanged.
  const look = (changes) => {
    const url = new URL(location.href);
    for (const [key, value] of Object.entries(changes)) value === null ? url.searchParams.delete(key) : url.searchParams.set(key, value);
    return exchange(url.href, true);
  };
  const exchange = async (url, keep) => {
    const answer = await fetch(url);
    const found = new DOMParser().parseFromString(await answer.text(), "text/html").querySelector("#history");
    if (!answer.ok || !found) return location.assign(url);
    document.querySelector("#history").replaceWith(found);
    if (keep) history.pushState(null, "", url);
    localTimes(found);
    utcDays(found);
    draw(found);
  };

  // A picture to keep: as it stands on the screen, on its own ground.
  const KEPT = ["fill", "fill-opacity", "stroke", "stroke-width", "stroke-dasharray", "stroke-linejoin", "paint-order", "font-size",
    "font-family", "font-weight", "text-anchor", "vector-effect", "overflow"];
  const alone = (part, { width, height }) => {
    const copy = part.cloneNode(true);
    const originals = [part, ...part.querySelectorAll("*")];
    [copy, ...copy.querySelectorAll("*")].forEach((element, k) => {
      const style = getComputedStyle(originals[k]);
      for (const name of KEPT) element.setAttribute(name, style.getPropertyValue(name));
    });
    for (const [name, value] of Object.entries({ xmlns: SVG, width, height })) copy.setAttribute(name, value);
    return new XMLSerializer().serializeToString(copy);
  };
  const save = async (section) => {
    const shown = [...section.querySelectorAll(".picture")].filter((picture) => picture.checkVisibility());
    const boxes = shown.map((picture) => picture.getBoundingClientRect());
    const scale = 2, title = 22;
    const canvas = document.createElement("canvas");
    canvas.width = scale * Math.max(...boxes.map((box) => box.width));
    canvas.height = scale * boxes.reduce((sum, box) => sum + box.height + title, 0);
    const pen = canvas.getContext("2d");
    pen.scale(scale, scale);
    const page = getComputedStyle(document.body);
    pen.fillStyle = page.backgroundColor;
    pen.fillRect(0, 0, canvas.width, canvas.height);
    let top = 0;
    for (const [k, picture] of shown.entries()) {
      pen.fillStyle = page.color;
      pen.font = `13px ${page.fontFamily}`;
      const caption = picture.parentElement.querySelector("figcaption").innerText.replace(/\s+/g, " ");
      pen.fillText(`${section.dataset.picture} ${caption}`, 4, top + 16);
      for (const part of picture.querySelectorAll(":scope > svg")) {
        const box = part.getBoundingClientRect();
        const image = new Image(box.width, box.height);
        image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(alone(part, box))}`;
        await image.decode();
        pen.drawImage(image, box.left - boxes[k].left, top + title + box.top - boxes[k].top, box.width, box.height);
      }
      top += boxes[k].height + title;
    }
    const link = document.createElement("a");
    link.download = `${section.dataset.picture}.png`;
    link.href = canvas.toDataURL("image/png");
    link.click();
  };

  const draw = (root) => {
    for (const picture of root.querySelectorAll(".picture")) pick(picture);
    for (const button of root.querySelectorAll("[data-save]")) {
      button.hidden = false;
      button.addEventListener("click", () => save(button.closest("[data-picture]")));
    }
    for (const link of root.querySelectorAll(".tabs a"))
      link.addEventListener("click", (event) => {
        if (event.ctrlKey || event.metaKey || event.shiftKey || event.button) return;
        event.preventDefault();
        exchange(link.href.replace(/#.*/, ""), true);
      });
  };
  addEventListener("popstate", () => { if (document.querySelector("#history")) exchange(location.href, false); });

  // Ticks at once what can be ticked one by one.
  for (const all of document.querySelectorAll("[data-all]")) {
    all.parentElement.hidden = false;
    all.addEventListener("change", () => {
      for (const one of document.querySelectorAll(`input[type=checkbox][name=${all.dataset.all}]`)) one.checked = all.checked;
    });
  }

  // A file that is chosen or dropped is previewed at once.
  for (const form of document.querySelectorAll("form[data-drop]")) {
    const input = form.querySelector("input[type=file]");
    input.addEventListener("change", () => { if (input.files.length) form.requestSubmit(); });
    form.addEventListener("dragover", (event) => { event.preventDefault(); form.classList.add("over"); });
    form.addEventListener("dragleave", () => form.classList.remove("over"));
    form.addEventListener("drop", (event) => {
      event.preventDefault();
      input.files = event.dataTransfer.files;
      if (input.files.length) form.requestSubmit();
    });
  }

  for (const picture of document.querySelectorAll(".picture")) if (!picture.closest("#history")) pick(picture);
  for (const part of document.querySelectorAll("#history")) draw(part);
})();
