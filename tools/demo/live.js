// While the demo runs it rewrites status.js beside the page; the page reads it, and itself once it has grown.
(() => {
  const box = document.getElementById("status"), key = "volute-demo-scroll:" + location.pathname;
  let touched = 0, answered = Date.now();
  for (const kind of ["pointerdown", "wheel", "keydown", "input", "touchmove"])
    addEventListener(kind, () => touched = Date.now(), {passive: true});
  try {
    const y = sessionStorage.getItem(key);
    if (y !== null) { history.scrollRestoration = "manual"; addEventListener("load", () => scrollTo(0, +y)); scrollTo(0, +y); }
    addEventListener("pagehide", () => sessionStorage.setItem(key, scrollY));
  } catch (e) {}
  window.voluteStatus = status => {
    answered = Date.now();
    box.querySelector(".now").textContent = status.text;
    box.querySelector(".rest").textContent = status.done + " of " + status.of + " steps are done. " + status.left + ".";
    const bar = box.querySelector("progress");
    bar.max = status.of;
    bar.value = status.done;
    if (status.age > 60) box.querySelector(".now").textContent = "Nothing has come for a minute. If the demo was ended, ./dev demo goes on.";
    const busy = Date.now() - touched < 4000 || [...document.querySelectorAll("video")].some(v => v.matches(":hover"));
    if (status.page != box.dataset.page && !busy) location.reload();
  };
  const ask = () => {
    const script = document.createElement("script");
    script.src = "status.js?" + Date.now();
    script.onload = script.onerror = () => script.remove();
    document.head.append(script);
  };
  setInterval(ask, 3000);
  ask();
})();
