"""SCRIPT: a number field that is left without a number shows again what is used.

Viser's page (1.1, `numberInputUtils.ts`) sends nothing for a field that is empty or holds "-" or
".", and the field stays so: what is used is the last number that was typed. Once the field is left,
or Enter is pressed, it goes back to what it was before it was typed in, as if that had been typed:
so the server is told, should a part of a number have been sent in between.
"""

# React hears of a value only if the element's own setter is passed by.
_SCRIPT = """
(() => {
  const before = new WeakMap();
  const setValue = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set;
  const fieldOf = (event) => event.target.closest?.("input.mantine-NumberInput-input");
  const isNumber = (text) => text.trim() !== "" && Number.isFinite(Number(text));
  const leave = (field) => {
    const kept = before.get(field);
    before.delete(field);
    if (kept === undefined || isNumber(field.value)) { return; }
    setValue.call(field, kept);
    field.dispatchEvent(new Event("input", { bubbles: true }));
  };
  document.addEventListener("beforeinput", (event) => {
    const field = fieldOf(event);
    if (field && !before.has(field) && isNumber(field.value)) { before.set(field, field.value); }
  }, true);
  // After the page's own listeners: those take a "-" away.
  const later = (event) => {
    const field = fieldOf(event);
    if (field) { setTimeout(() => leave(field)); }
  };
  document.addEventListener("focusout", later, true);
  document.addEventListener("keydown", (event) => event.key === "Enter" && later(event), true);
})();
"""
SCRIPT = f"<script>{_SCRIPT}</script>"
