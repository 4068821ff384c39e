// Films play while they are seen, unless the reader asked for less motion.
if (!matchMedia("(prefers-reduced-motion: reduce)").matches && "IntersectionObserver" in window) {
  const seen = new IntersectionObserver(entries => entries.forEach(({target, isIntersecting}) =>
    isIntersecting ? target.play().catch(() => {}) : target.pause()), {threshold: 0.4});
  document.querySelectorAll("video").forEach(video => seen.observe(video));
}

// Sliders: which picture of a stack is shown with its command, and where the border of two pictures is.
document.querySelectorAll(".slide input").forEach(input => {
  const figure = input.closest("figure"), stack = figure.querySelector(".stack");
  const show = () => {
    if (stack.classList.contains("wipe")) {
      stack.style.setProperty("--at", input.value + "%");
      return;
    }
    [...stack.children].forEach((image, i) => image.classList.toggle("shown", i == input.value));
    figure.querySelectorAll(".made").forEach((made, i) => made.hidden = i != input.value);
    figure.querySelector("output").textContent = stack.children[input.value].dataset.name;
  };
  input.addEventListener("input", show);
  show();
});

function copied(text) {
  const area = document.createElement("textarea");
  area.value = text;
  document.body.append(area);
  area.select();
  const done = document.execCommand("copy");
  area.remove();
  return done ? Promise.resolve() : Promise.reject();
}
document.querySelectorAll(".command button").forEach(button => button.addEventListener("click", () => {
  const text = button.parentElement.querySelector("code").textContent;
  const done = navigator.clipboard && isSecureContext ? navigator.clipboard.writeText(text).catch(() => copied(text)) : copied(text);
  done.then(() => { button.textContent = "Copied"; setTimeout(() => button.textContent = "Copy", 1500); }, () => {});
}));
