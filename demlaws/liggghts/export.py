class Grain: pass
def export(): pass
def stock_fit(): pass
