"""The quickstart: one rough contact, loaded and unloaded twice, beside Hertz."""

import demlaws as dl

granite = dl.materials.granite
pair = dl.Contact.between(granite, granite, radius1="8.7mm", radius2="8.7mm")
law = dl.law("pohrt-popov", pair, unloading="hertz")
path = dl.driver.force_controlled(law, [25, 0, 50, 0])
print(path)

ax = dl.law("hertz", pair).plot(unload_at=50.0, label="hertz, smooth")
path.plot(ax, color="tab:red", label="pohrt-popov, two cycles")
ax.legend()
ax.figure.savefig("quickstart.png")
