// Filters by class and split, the large view, the search among numbers. Without it the page shows everything.
"use strict";
(() => {
  const root = document.documentElement;
  root.classList.add("js");
  const all = (selector, within = document) => [...within.querySelectorAll(selector)];
  const byId = (id) => document.getElementById(id);
  const chosen = (name) => all(`input[name="${name}"]`).find((input) => input.checked);
  const dimmer = document.head.appendChild(document.createElement("style"));

  function apply() {
    const klass = chosen("class")?.value ?? "";
    const split = chosen("split")?.value ?? "";
    const fits = (item) => (!klass || item.dataset.class === klass) && (!split || item.dataset.split === split);
    all("#sheet > .card, .frames > .frame").forEach((item) => { item.hidden = !fits(item); });
    const shown = all("#sheet > .card").filter((card) => !card.hidden).length;
    if (byId("shown")) byId("shown").textContent = `${shown} ${shown === 1 ? "sample" : "samples"} shown`;
    if (byId("none")) byId("none").hidden = shown > 0;
    // Histograms keep every class, and dim those that are filtered away.
    const number = chosen("class")?.dataset.c;
    dimmer.textContent = number === undefined ? "" : `.bars path:not([data-c="${number}"]) { fill-opacity: .13 !important; }`;
  }

  function fromAddress() {
    const text = location.hash.slice(1);
    if (!text.includes("=")) return;
    const wanted = new URLSearchParams(text);
    for (const name of ["class", "split"]) {
      const inputs = all(`input[name="${name}"]`);
      const input = inputs.find((one) => one.value === (wanted.get(name) ?? ""));
      if (input) input.checked = true;
    }
    if (byId("labels")) byId("labels").checked = wanted.get("labels") !== "off";
    if (byId("find")) { byId("find").value = wanted.get("find") ?? ""; find(); }
    apply();
  }

  function toAddress() {
    const now = new URLSearchParams();
    for (const name of ["class", "split"]) if (chosen(name)?.value) now.set(name, chosen(name).value);
    if (byId("labels")?.checked === false) now.set("labels", "off");
    if (byId("find")?.value) now.set("find", byId("find").value);
    history.replaceState(null, "", now.size ? `#${now}` : location.pathname + location.search);
    apply();
  }

  function find() {
    const words = byId("find").value.toLowerCase().split(/\s+/).filter(Boolean);
    const fits = (item) => words.every((word) => `${item.dataset.name} ${item.title}`.toLowerCase().includes(word));
    all(".multiple").forEach((item) => { item.hidden = !fits(item); });
    all("#numbers .group").forEach((group) => { group.hidden = !all(".multiple", group).some((item) => !item.hidden); });
  }

  // The large view: one sample, the neighbours by arrow keys. The bar stays, and with it the focus; only the card changes.
  const dialog = document.body.appendChild(document.createElement("dialog"));
  dialog.setAttribute("aria-label", "Sample, large");
  const bar = dialog.appendChild(document.createElement("div"));
  bar.className = "bar";
  const actions = [["\u2190 previous", () => move(-1)], ["next \u2192", () => move(1)]];
  if (byId("labels")) actions.push(["labels", () => byId("labels").click()]);
  actions.push(["close", () => dialog.close()]);
  for (const [words, action] of actions) {
    const button = bar.appendChild(document.createElement("button"));
    button.type = "button";
    button.textContent = words;
    button.addEventListener("click", action);
  }
  let current = null;
  function show(card) {
    current = card;
    const copy = card.cloneNode(true);
    copy.removeAttribute("id");
    copy.querySelector(".maps").removeAttribute("href");
    dialog.querySelector(".card")?.remove();
    dialog.append(copy);
    if (!dialog.open) dialog.showModal();
  }
  function move(by) {
    const cards = all("#sheet > .card").filter((card) => !card.hidden);
    const next = cards[(cards.indexOf(current) + by + cards.length) % cards.length];
    if (next) show(next);
  }
  // A click beside the buttons takes the focus out of the dialog, so the whole page listens.
  addEventListener("keydown", (event) => {
    if (!dialog.open || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "ArrowLeft") move(-1);
    else if (event.key === "ArrowRight") move(1);
    else if (event.key === "l") byId("labels")?.click();
    else return;
    event.preventDefault();
  });
  dialog.addEventListener("click", (event) => { if (event.target === dialog) dialog.close(); });
  dialog.addEventListener("close", () => current?.querySelector(".maps").focus());
  byId("sheet")?.addEventListener("click", (event) => {
    const maps = event.target.closest("a.maps");
    if (!maps || event.ctrlKey || event.metaKey || event.shiftKey) return;
    event.preventDefault();
    show(maps.closest(".card"));
  });

  all('input[name="class"], input[name="split"]').forEach((input) => input.addEventListener("change", toAddress));
  byId("labels")?.addEventListener("change", toAddress);
  byId("find")?.addEventListener("input", () => { find(); toAddress(); });
  // A link to a section would take the filter's place in the address.
  all("nav a").forEach((link) => link.addEventListener("click", (event) => {
    const section = byId(link.hash.slice(1));
    if (!section || !location.hash.includes("=") || event.ctrlKey || event.metaKey || event.shiftKey) return;
    event.preventDefault();
    section.tabIndex = -1;
    section.focus({ preventScroll: true });
    section.scrollIntoView();
  }));
  addEventListener("hashchange", fromAddress);
  addEventListener("beforeprint", () => all("details.group, details.fault").forEach((one) => { one.open = true; }));
  fromAddress();
})();
