// What the pages gain with scripts: times in the viewer's zone, plots to zoom. Nothing is only here.
"use strict";
(() => {
  const two = (n) => String(n).padStart(2, "0");
  const local = (at) =>
    `${at.getFullYear()}-${two(at.getMonth() + 1)}-${two(at.getDate())} ${two(at.getHours())}:${two(at.getMinutes())}`;

  for (const time of document.querySelectorAll("time[datetime]")) {
    const at = new Date(time.dateTime);
    if (isNaN(at)) continue;
    time.title = time.textContent;
    time.textContent = "day" in time.dataset ? local(at).slice(0, 10) : local(at);
  }

  // Local times say no zone: the head of the page does.
  const zone = document.getElementById("zone");
  if (zone) {
    const minutes = -new Date().getTimezoneOffset();
    const hours = `${Math.floor(Math.abs(minutes) / 60)}${Math.abs(minutes) % 60 ? `:${two(Math.abs(minutes) % 60)}` : ""}`;
    zone.textContent = minutes ? `UTC${minutes < 0 ? "-" : "+"}${hours}` : "UTC";
  }

  // "/" leads to the search, unless something is being written.
  document.addEventListener("keydown", (event) => {
    const find = document.getElementById("find");
    if (event.key !== "/" || event.ctrlKey || event.metaKey || event.altKey || !find) return;
    if (event.target.closest("input, textarea, select, [contenteditable]")) return;
    event.preventDefault();
    find.focus();
    find.select();
  });

  const colour = (name) => {
    // Resolves light-dark(): a custom property alone keeps it unresolved.
    const probe = document.createElement("span");
    probe.style.color = `var(--${name})`;
    document.body.append(probe);
    const resolved = getComputedStyle(probe).color;
    probe.remove();
    return resolved;
  };

  // By status: a hollow circle where nothing is decided, a triangle where a rule says that a limit is passed.
  const LOOKS = {
    in_tolerance: ["circle", "good"], not_enough_data: ["circle-open", "quiet"], too_uncertain: ["circle-open", "open"],
    borderline: ["circle-open", "open"], overdue: ["circle-open", "open"], drifting: ["triangle-up-open", "open"],
    unconfirmed: ["triangle-up-open", "bad"], out_of_tolerance: ["triangle-up", "bad"], confirmed: ["triangle-up", "bad"],
  };
  const INDEX = { I: "<sub>I</sub>", S: "<sub>S</sub>", O: "<sub>O</sub>" };
  const title = (symbol) => symbol.replace(/_([ISO])$/, (_, index) => INDEX[index]);

  // A line from one baseline to the next would connect two gyros: a gap stands where a new one begins.
  const withGaps = (strip, series) => {
    const starts = strip.bands.slice(1).map(([from]) => from);
    const gaps = series.t.flatMap((t, k) => (k && starts.some((from) => series.t[k - 1] < from && from <= t) ? [k] : []));
    const spread = (list, gap) => list.flatMap((one, k) => (gaps.includes(k) ? [gap, one] : [one]));
    const { t, v, sd, status, place } = series;
    return {
      ...series, t: spread(t, null), v: spread(v, null), sd: sd && spread(sd, null),
      status: spread(status, 0), place: spread(place, 0),
    };
  };

  // Value and uncertainty to the same place.
  const figures = (value, sd) => {
    if (!sd) return value.toFixed(6);
    const places = Math.min(9, Math.max(0, 1 - Math.floor(Math.log10(Number(sd.toPrecision(2))))));
    return `${value.toFixed(places)} ± ${sd.toFixed(places)}`;
  };

  const tracesOf = (plot, strip, row, palette) =>
    strip.series.map((thinned, i) => {
      const main = !thinned.bench;
      const series = main ? withGaps(strip, thinned) : thinned;
      const looks = series.status.map((s) => LOOKS[plot.statuses[s][0]]);
      return {
        type: "scatter",
        mode: main ? "lines+markers" : "markers",
        name: series.name,
        legendgroup: series.name,
        showlegend: row === 0,
        x: series.t.map((t) => (t === null ? null : new Date(t))),
        y: series.v,
        error_y: series.sd ? { type: "data", array: series.sd, thickness: 1, width: 2, color: palette.quiet } : undefined,
        line: { color: palette.quiet, width: 1 },
        marker: {
          size: main ? 7 : 9,
          color: main ? looks.map(([, name]) => palette[name]) : palette.link,
          symbol: main ? looks.map(([symbol]) => symbol) : i % 2 ? "diamond-open" : "diamond",
        },
        text: series.t.map((t, k) => {
          if (t === null) return "";
          const status = main ? `<br>${plot.statuses[series.status[k]][1]}` : "";
          return (
            `<b>${title(strip.symbol)} = ${figures(series.v[k], series.sd && series.sd[k])}</b> ${plot.unit}<br>${series.name}<br>` +
            `${local(new Date(t))}<br>${new Date(t).toISOString().slice(0, 16).replace("T", " ")} UTC<br>` +
            escaped(series.places[series.place[k]]) + status
          );
        }),
        hovertemplate: "%{text}<extra></extra>",
        xaxis: "x",
        yaxis: row ? `y${row + 1}` : "y",
      };
    });

  const escaped = (text) => text.replace(/[<>&]/g, (c) => ({ "<": "&lt;", ">": "&gt;", "&": "&amp;" })[c]);

  const shapesOf = (strip, row, palette) => {
    const axis = row ? `y${row + 1}` : "y";
    const of = (shape) => ({ xref: "x", yref: axis, layer: "below", ...shape });
    return strip.bands.flatMap(([from, to, level, budget, control]) => {
      const [x0, x1] = [new Date(from), new Date(to)];
      const middle = of({ type: "line", x0, x1, y0: level, y1: level, line: { color: palette.quiet, width: 1, dash: "dash" } });
      const limits = control === null ? [] : [level - control, level + control].map((y) =>
        of({ type: "line", x0, x1, y0: y, y1: y, line: { color: palette.quiet, width: 1, dash: "dot" } }));
      if (budget === null) return [middle, ...limits];
      const band = of({
        type: "rect", x0, x1, y0: level - budget, y1: level + budget, fillcolor: palette.band, line: { width: 0 },
      });
      return [band, middle, ...limits];
    });
  };

  // Marks that would be written over one another share one line and one label.
  const together = (plot) => {
    const times = plot.strips.flatMap((strip) => strip.series.flatMap((series) => series.t));
    const near = 0.015 * (times.reduce((a, b) => Math.max(a, b), -Infinity) - times.reduce((a, b) => Math.min(a, b), Infinity));
    const joined = [];
    for (const mark of [...plot.marks].sort((a, b) => a.t - b.t)) {
      const last = joined[joined.length - 1];
      if (last && last.until === mark.until && mark.t - last.t < near) {
        last.label += ` · ${mark.label}`;
        last.event ||= mark.event;
      } else joined.push({ ...mark });
    }
    return joined;
  };

  // Every figure beside an axis with as many decimals as its steps need.
  const DECIMALS = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9].map((k) => ({
    dtickrange: [0.9 * 10 ** -k, k ? 9 * 10 ** -k : null], value: `.${k}f`,
  }));

  // Room above the strips, for the legend and the title of the first one, and below, for dates; pixels.
  const [TOP, BOTTOM] = [58, 40];

  const layoutOf = (plot, palette, narrow) => {
    const rows = plot.strips.length;
    const layout = {
      height: TOP + BOTTOM + rows * (narrow ? 185 : 220),
      margin: { l: narrow ? 60 : 66, r: 12, t: TOP, b: BOTTOM },
      paper_bgcolor: "rgba(0,0,0,0)",
      plot_bgcolor: "rgba(0,0,0,0)",
      font: { color: palette.text, family: getComputedStyle(document.body).fontFamily, size: narrow ? 11 : 12 },
      hoverlabel: { align: "left", bgcolor: palette.raised, bordercolor: palette.line, font: { color: palette.text } },
      legend: { orientation: "h", yref: "container", y: 1, yanchor: "top", x: 0 },
      hovermode: "closest",
      dragmode: "zoom",
      // Dates in digits: the same in every language.
      xaxis: { type: "date", tickformatstops: [
        { dtickrange: [null, 36e5], value: "%H:%M:%S\n%Y-%m-%d" }, { dtickrange: [36e5, 864e5], value: "%H:%M\n%Y-%m-%d" },
        { dtickrange: [864e5, "M1"], value: "%m-%d\n%Y" }, { dtickrange: ["M1", "M12"], value: "%Y-%m" }, { dtickrange: ["M12", null], value: "%Y" },
      ], gridcolor: palette.line, linecolor: palette.line, anchor: rows > 1 ? `y${rows}` : "y" },
      shapes: [],
      annotations: [],
    };
    // Holds the title of the strip below.
    const gap = 0.06;
    plot.strips.forEach((strip, row) => {
      const size = (1 - gap * (rows - 1)) / rows;
      const top = 1 - row * (size + gap);
      layout[row ? `yaxis${row + 1}` : "yaxis"] = {
        domain: [Math.max(0, top - size), top],
        gridcolor: palette.line, zeroline: false, linecolor: palette.line, tickformatstops: DECIMALS, nticks: 6, automargin: true,
      };
      // Above the strip: beside it there are figures of any width.
      layout.annotations.push({
        xref: "paper", yref: "paper", x: 0, y: top, xanchor: "left", yanchor: "bottom", showarrow: false,
        text: `${title(strip.symbol)}, ${plot.unit}`,
      });
      layout.shapes.push(...shapesOf(strip, row, palette));
    });
    for (const mark of together(plot)) {
      const x = new Date(mark.t);
      const line = { color: mark.event ? palette.bad : palette.quiet, width: 1, dash: mark.event ? "solid" : "dot" };
      layout.shapes.push({ type: "line", xref: "x", yref: "paper", x0: x, x1: x, y0: 0, y1: 1, line });
      // What took time is shaded from its beginning to its end.
      if (mark.until !== null)
        layout.shapes.push({
          type: "rect", xref: "x", yref: "paper", layer: "below", x0: x, x1: new Date(mark.until), y0: 0, y1: 1,
          fillcolor: palette.bad, opacity: 0.15, line: { width: 0 },
        });
      layout.annotations.push({
        xref: "x", yref: "paper", x, y: 1, yanchor: "top", xanchor: "left", textangle: 90, showarrow: false,
        text: escaped(mark.label), font: { size: 10, color: line.color },
      });
    }
    return layout;
  };

  // Everything; about what stands alone, a month and the budget, where the axes would find no measure of their own.
  const rangesOfAll = (plot) => {
    const ranges = {};
    const axis = (name, values, around, of) => {
      const [low, high] = [values.reduce((a, b) => Math.min(a, b), Infinity), values.reduce((a, b) => Math.max(a, b), -Infinity)];
      if (low === high) ranges[`${name}.range`] = [of(low - around), of(high + around)];
      else ranges[`${name}.autorange`] = true;
    };
    const times = plot.strips.flatMap((strip) => strip.series.flatMap((series) => series.t));
    axis("xaxis", [...times, ...plot.marks.map((mark) => mark.t)], plot.alone, (t) => new Date(t));
    plot.strips.forEach((strip, row) => {
      const levels = strip.bands.flatMap(([, , level, budget]) => [level - (budget || 0), level + (budget || 0)]);
      const values = [...levels, ...strip.series.flatMap((series) => series.v)];
      axis(row ? `yaxis${row + 1}` : "yaxis", values, strip.around, (v) => v);
    });
    return ranges;
  };

  // All that was measured since an instant, in every strip.
  const rangesSince = (plot, since) => {
    const ranges = {};
    let end = since;
    plot.strips.forEach((strip, row) => {
      let [low, high] = [Infinity, -Infinity];
      for (const series of strip.series) {
        series.t.forEach((t, k) => {
          if (t < since) return;
          end = Math.max(end, t);
          low = Math.min(low, series.v[k]);
          high = Math.max(high, series.v[k]);
        });
      }
      for (const [from, , level, budget] of strip.bands) {
        if (from < since) continue;
        low = Math.min(low, level - (budget || 0));
        high = Math.max(high, level + (budget || 0));
      }
      const edge = high > low ? 0.06 * (high - low) : strip.around;
      if (low <= high) ranges[row ? `yaxis${row + 1}.range` : "yaxis.range"] = [low - edge, high + edge];
    });
    const day = 864e5;
    ranges["xaxis.range"] = [new Date(since - day), new Date(end + 0.04 * (end - since) + day)];
    return ranges;
  };

  // Where a repair has moved the level by far more than the budget, the whole history shows neither the budget nor a drift.
  const isDwarfed = (plot) =>
    plot.since !== null && plot.strips.some((strip) => {
      const levels = strip.bands.map(([, , level]) => level);
      const budget = strip.bands.length ? strip.bands[strip.bands.length - 1][3] : null;
      return budget !== null && Math.max(...levels) - Math.min(...levels) > 10 * budget;
    });

  const draw = (place) => {
    const plot = JSON.parse(place.nextElementSibling.textContent);
    const tools = place.previousElementSibling;
    const palette = {};
    const paint = () => {
      for (const name of ["text", "quiet", "line", "link", "bad", "open", "good", "band", "raised"]) palette[name] = colour(name);
      const traces = plot.strips.flatMap((strip, row) => tracesOf(plot, strip, row, palette));
      const layout = layoutOf(plot, palette, place.clientWidth < 600);
      return Plotly.react(place, traces, layout, { responsive: true, displaylogo: false, displayModeBar: false });
    };
    const show = (wanted) => {
      for (const button of tools.querySelectorAll("[aria-pressed]"))
        button.setAttribute("aria-pressed", String(button.dataset.zoom === wanted));
      return Plotly.relayout(place, wanted === "since" ? rangesSince(plot, plot.since) : rangesOfAll(plot));
    };
    paint().then(() => show(isDwarfed(plot) ? "since" : "all")).then(() => { place.dataset.drawn = "true"; });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", paint);
    tools.hidden = false;
    tools.addEventListener("click", (event) => {
      const wanted = event.target.dataset.zoom;
      if (wanted === "picture") {
        const size = { width: 1200, height: place.clientHeight * 1200 / Math.max(place.clientWidth, 600) };
        Plotly.downloadImage(place, { format: "png", filename: plot.name, scale: 2, ...size });
      } else if (wanted) {
        show(wanted);
      }
    });
  };

  // A file that is dropped or chosen becomes the text of the form, and is previewed at once.
  for (const form of document.querySelectorAll("form[data-drop]")) {
    const input = form.querySelector("input[type=file]");
    const take = async (file) => {
      if (!file) return;
      form.querySelector("textarea").value = await file.text();
      const name = form.querySelector("input[name=file]");
      [name.disabled, name.value] = [false, file.name];
      form.requestSubmit();
    };
    input.closest("[hidden]").hidden = false;
    input.addEventListener("change", () => take(input.files[0]));
    form.addEventListener("dragover", (event) => { event.preventDefault(); form.classList.add("over"); });
    form.addEventListener("dragleave", () => form.classList.remove("over"));
    form.addEventListener("drop", (event) => { event.preventDefault(); take(event.dataTransfer.files[0]); });
  }

  if (window.Plotly) document.querySelectorAll("[data-plot=history]").forEach(draw);
})();
