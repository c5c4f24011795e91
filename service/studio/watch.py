"""SCRIPT: the page says that its server is gone, and opens again once that is back.

Viser's page tries to connect again each second while it has the focus, and says so by three red
dots; once a server had been away for a minute, it was seen not to find back in a quarter of one.
"""

# Once is not enough: a page is not opened anew for a hiccup, nor for a server that is only slow.
_SCRIPT = """
(() => {
  const banner = document.createElement("div");
  banner.id = "wayproof-away";
  banner.setAttribute("role", "alert");
  banner.textContent = "The server does not answer. The page opens again once it does.";
  banner.style.cssText = "position:fixed;left:0;right:0;top:0;z-index:10000;padding:0.7em 1em;"
    + "background:#e63946;color:white;font:600 14px system-ui,sans-serif;text-align:center";
  let failures = 0;
  const look = async () => {
    try {
      const signal = AbortSignal.timeout(5000);
      await fetch("/", { method: "HEAD", cache: "no-store", signal });
      if (failures >= 2) { location.reload(); return; }
      failures = 0;
    } catch (fault) {
      if (fault instanceof TypeError) { failures += 1; }
      if (failures === 2) { document.body.append(banner); }
    }
    setTimeout(look, failures ? 1000 : 2000);
  };
  setTimeout(look, 2000);
})();
"""
SCRIPT = f"<script>{_SCRIPT}</script>"
