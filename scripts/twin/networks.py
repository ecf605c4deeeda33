"""PyTorch twins of taxel's networks, written from the papers and not from the Rust code.

`build(name, **settings)` returns a module whose `forward` takes the network's inputs in order and
whose `state_dict` names are taxel's. A new network is its module and an entry of `TWINS`, at the end.
"""

from collections import OrderedDict

import numpy as np
import torch
from torch import nn

import image_networks
from twins import DEEP, IMAGE, SIGNAL, TENSOR, Twin


def conv(dims):
    return nn.Conv1d if dims == 1 else nn.Conv2d


def norm(dims, channels):
    return (nn.BatchNorm1d if dims == 1 else nn.BatchNorm2d)(channels)


def max_pool(dims, *args, **kwargs):
    return (nn.MaxPool1d if dims == 1 else nn.MaxPool2d)(*args, **kwargs)


class ConvBn(nn.Module):
    """Convolution and batch norm, ReLU where asked for."""

    def __init__(self, dims, inputs, outputs, kernel, stride=1, relu=True):
        super().__init__()
        self.conv = conv(dims)(inputs, outputs, kernel, stride=stride, padding=kernel // 2)
        self.bn = norm(dims, outputs)
        self.relu = relu

    def forward(self, x):
        x = self.bn(self.conv(x))
        return torch.relu(x) if self.relu else x


class Vgg6Lite(nn.Module):
    """Kaewrakmuk and Srinonchat 2026, section 3.1.1."""

    width = 64

    def __init__(self, dims, inputs):
        super().__init__()
        widths = [inputs, 16, 32, 64, 64, 64]
        self.convs = nn.ModuleList(ConvBn(dims, a, b, 3) for a, b in zip(widths, widths[1:]))
        self.pools = [max_pool(dims, 2, 2, ceil_mode=True) if i in (0, 1, 4) else nn.Identity() for i in range(5)]

    def forward(self, x):
        for block, pool in zip(self.convs, self.pools):
            x = pool(block(x))
        return x.flatten(2).mean(2)


class Residual(nn.Module):
    def __init__(self, dims, inputs, outputs, stride):
        super().__init__()
        self.conv1 = ConvBn(dims, inputs, outputs, 3, stride)
        self.conv2 = ConvBn(dims, outputs, outputs, 3, relu=False)
        if stride > 1:
            self.shortcut = ConvBn(dims, inputs, outputs, 1, stride, relu=False)

    def forward(self, x):
        skip = self.shortcut(x) if hasattr(self, "shortcut") else x
        return torch.relu(self.conv2(self.conv1(x)) + skip)


class ResNet8Lite(nn.Module):
    """Kaewrakmuk and Srinonchat 2026, section 3.1.2."""

    width = 32

    def __init__(self, dims, inputs):
        super().__init__()
        self.stem = ConvBn(dims, inputs, 16, 5)
        self.pool = max_pool(dims, 3, 2, padding=1)
        self.identity1 = Residual(dims, 16, 16, 1)
        self.downsample = Residual(dims, 16, 32, 2)
        self.identity2 = Residual(dims, 32, 32, 1)

    def forward(self, x):
        x = self.pool(self.stem(x))
        return self.identity2(self.downsample(self.identity1(x))).flatten(2).mean(2)


class Dense(nn.Module):
    def __init__(self, dims, inputs):
        super().__init__()
        self.bn1 = norm(dims, inputs)
        self.conv1 = conv(dims)(inputs, 64, 1)
        self.bn2 = norm(dims, 64)
        self.conv2 = conv(dims)(64, 16, 3, padding=1)

    def forward(self, x):
        grown = self.conv2(torch.relu(self.bn2(self.conv1(torch.relu(self.bn1(x))))))
        return torch.cat([x, grown], 1)


class DenseNet6Lite(nn.Module):
    """Kaewrakmuk and Srinonchat 2026, section 3.1.3."""

    width = 48

    def __init__(self, dims, inputs):
        super().__init__()
        self.stem = ConvBn(dims, inputs, 16, 5)
        self.pool = max_pool(dims, 3, 2, padding=1)
        self.block1 = Dense(dims, 16)
        self.transition = (nn.AvgPool1d if dims == 1 else nn.AvgPool2d)(2)
        self.block2 = Dense(dims, 32)
        self.norm = norm(dims, 48)

    def forward(self, x):
        x = self.block2(self.transition(self.block1(self.pool(self.stem(x)))))
        return torch.relu(self.norm(x)).flatten(2).mean(2)


class Hybrid(nn.Module):
    """Kaewrakmuk and Srinonchat 2026, section 3.2."""

    def __init__(self, temporal, spatial, fuse, in_channels, image_channels, classes):
        super().__init__()
        self.temporal = temporal(1, in_channels)
        self.spatial = spatial(2, image_channels)
        width = temporal.width + spatial.width
        if fuse:
            self.fuse = nn.Linear(width, width // 2)
            width //= 2
        self.fc = nn.Linear(width, classes)

    def forward(self, signal, image):
        joined = torch.cat([self.temporal(signal), self.spatial(image)], 1)
        if hasattr(self, "fuse"):
            joined = torch.relu(self.fuse(joined))
        return self.fc(joined)


class Mlp(nn.Module):
    """Kaewrakmuk and Srinonchat 2026, Table 5."""

    def __init__(self, in_features, hidden, classes):
        super().__init__()
        self.fc1 = nn.Linear(in_features, hidden)
        self.fc2 = nn.Linear(hidden, classes)

    def forward(self, signal):
        return self.fc2(torch.relu(self.fc1(signal.flatten(1))))


class DeepMlp(nn.Module):
    """taxel's own: hidden layers with a batch norm each."""

    def __init__(self, in_features, hidden, layers, classes):
        super().__init__()
        self.layers = layers
        for layer in range(1, layers + 1):
            setattr(self, f"fc{layer}", nn.Linear(in_features if layer == 1 else hidden, hidden))
            setattr(self, f"bn{layer}", nn.BatchNorm1d(hidden))
        self.head = nn.Linear(hidden, classes)

    def forward(self, signal):
        x = signal.flatten(1)
        for layer in range(1, self.layers + 1):
            x = torch.relu(getattr(self, f"bn{layer}")(getattr(self, f"fc{layer}")(x)))
        return self.head(x)


class LayerNormMlp(nn.Module):
    """taxel's own: hidden layers with a layer norm each."""

    def __init__(self, in_features, hidden, layers, classes):
        super().__init__()
        self.layers = layers
        for layer in range(1, layers + 1):
            setattr(self, f"fc{layer}", nn.Linear(in_features if layer == 1 else hidden, hidden))
            setattr(self, f"ln{layer}", nn.LayerNorm(hidden))
        self.head = nn.Linear(hidden, classes)

    def forward(self, signal):
        x = signal.flatten(1)
        for layer in range(1, self.layers + 1):
            x = torch.relu(getattr(self, f"ln{layer}")(getattr(self, f"fc{layer}")(x)))
        return self.head(x)


class Lstm(nn.Module):
    """Kaewrakmuk and Srinonchat 2026, Table 5: the last hidden state of one layer that reads the sensors step by step."""

    def __init__(self, in_channels, hidden, classes, **_sizes):
        super().__init__()
        self.lstm = nn.LSTM(in_channels, hidden, batch_first=True)
        self.fc = nn.Linear(hidden, classes)

    def forward(self, signal):
        outputs, _ = self.lstm(signal.transpose(1, 2))
        return self.fc(outputs[:, -1])


class Fcn(nn.Module):
    """Wang et al. 2017: three convolutions that keep the length, mean over time."""

    def __init__(self, in_channels, classes, **_sizes):
        super().__init__()
        layers = [(in_channels, 128, 8), (128, 256, 5), (256, 128, 3)]
        layer = lambda a, b, kernel: OrderedDict(conv=nn.Conv1d(a, b, kernel, padding="same"), bn=nn.BatchNorm1d(b))  # noqa: E731
        self.convs = nn.ModuleList(nn.Sequential(layer(*sizes)) for sizes in layers)
        self.fc = nn.Linear(128, classes)

    def forward(self, x):
        for conv in self.convs:
            x = torch.relu(conv(x))
        return self.fc(x.mean(2))


class DsCnn(nn.Module):
    """Zhang et al. 2017, small, over time alone: a convolution, four depthwise and pointwise ones, mean over time."""

    def __init__(self, in_channels, classes, **_sizes):
        super().__init__()
        self.stem = self.layer(in_channels, 10, stride=2, padding=4)
        depthwise = lambda: self.layer(64, 3, padding=1, groups=64)  # noqa: E731
        pairs = [OrderedDict(depthwise=depthwise(), pointwise=self.layer(64, 1)) for _ in range(4)]
        self.blocks = nn.ModuleList(nn.Sequential(pair) for pair in pairs)
        self.fc = nn.Linear(64, classes)

    @staticmethod
    def layer(inputs, kernel, **how):
        convolution = nn.Conv1d(inputs, 64, kernel, bias=False, **how)
        return nn.Sequential(OrderedDict(conv=convolution, bn=nn.BatchNorm1d(64), relu=nn.ReLU()))

    def forward(self, x):
        x = self.stem(x)
        for block in self.blocks:
            x = block(x)
        return self.fc(x.mean(2))


class TactNet(nn.Module):
    """Gandarias et al. 2019: convolutions of 5, then 3, each followed by a pool."""

    def __init__(self, in_channels, widths, height, width, classes):
        super().__init__()
        channels = zip([in_channels, *widths], widths)
        self.convs = nn.ModuleList(ConvBn(2, a, b, 3 if i else 5) for i, (a, b) in enumerate(channels))
        for _ in widths:
            height, width = -(-height // 2), -(-width // 2)
        self.fc = nn.Linear(widths[-1] * height * width, classes)

    def forward(self, x):
        for block in self.convs:
            x = nn.functional.max_pool2d(block(x), 2, 2, ceil_mode=True)
        return self.fc(x.flatten(1))


class TactBlock(nn.Module):
    def __init__(self, inputs, outputs):
        super().__init__()
        self.conv1 = ConvBn(2, inputs, outputs, 3)
        self.conv2 = ConvBn(2, outputs, outputs, 3, relu=False)
        if inputs != outputs:
            self.shortcut = ConvBn(2, inputs, outputs, 3, relu=False)

    def forward(self, x):
        skip = self.shortcut(x) if hasattr(self, "shortcut") else x
        return torch.relu(self.conv2(self.conv1(x)) + skip)


class TactResNet(nn.Module):
    """Gandarias et al. 2019: four residual blocks between two pools."""

    def __init__(self, in_channels, height, width, classes):
        super().__init__()
        self.stem = ConvBn(2, in_channels, 64, 5, stride=2)
        self.res2, self.res3 = TactBlock(64, 64), TactBlock(64, 64)
        self.res4, self.res5 = TactBlock(64, 128), TactBlock(128, 128)
        after = [((size - 1) // 2 + 1 - 3) // 2 + 1 - 4 for size in (height, width)]
        self.fc = nn.Linear(128 * after[0] * after[1], classes)

    def forward(self, x):
        x = nn.functional.max_pool2d(self.stem(x), 3, 2)
        x = self.res5(self.res4(self.res3(self.res2(x))))
        return self.fc(nn.functional.max_pool2d(x, 5, 1).flatten(1))


class TactNet3d(nn.Module):
    """Gandarias et al. 2019b and Pastor et al. 2019: unpadded 3D convolutions, by default without a pool."""

    def __init__(self, filters, kernels, classes, in_channels=1, height=28, width=50, frames=10, hidden=64, pool=1, dropout=0.2):
        super().__init__()
        kernels = [kernels[min(i, 1)] for i in range(len(filters))]
        self.convs = nn.ModuleList(nn.Conv3d(a, b, k) for a, b, k in zip([in_channels, *filters], filters, kernels))
        self.bns = nn.ModuleList(nn.BatchNorm3d(n, eps=1e-5) for n in filters)
        size = [height, width, frames]
        for kernel in kernels:
            size = [(s - k + 1) // pool for s, k in zip(size, kernel)]
        self.fc3 = nn.Linear(filters[-1] * size[0] * size[1] * size[2], hidden)
        self.drop3 = nn.Dropout(dropout)
        self.fc4 = nn.Linear(hidden, classes)
        self.pool = pool

    def forward(self, x):
        for conv3d, bn in zip(self.convs, self.bns):
            x = torch.relu(bn(conv3d(x)))
            x = nn.functional.max_pool3d(x, self.pool) if self.pool > 1 else x
        return self.fc4(self.drop3(torch.relu(self.fc3(x.flatten(1)))))


class Frames(nn.Module):
    """Convolution and batch norm of frames, the last axis, which share their weights."""

    def __init__(self, inputs, outputs, kernel):
        super().__init__()
        self.conv = nn.Conv3d(inputs, outputs, (kernel, kernel, 1), padding=(kernel // 2, kernel // 2, 0))
        self.bn = nn.BatchNorm3d(outputs)

    def forward(self, x):
        return torch.relu(self.bn(self.conv(x)))


class TactNetGru(nn.Module):
    """The convolutions of TactNet6 on every frame, a mean over the places of each, a GRU over frames."""

    def __init__(self, in_channels, hidden, classes, **_sizes):
        super().__init__()
        widths = [in_channels, 8, 16, 32, 64, 128]
        self.convs = nn.ModuleList(Frames(a, b, 5 if i == 0 else 3) for i, (a, b) in enumerate(zip(widths, widths[1:])))
        self.gru = nn.GRU(widths[-1], hidden, batch_first=True)
        self.fc = nn.Linear(hidden, classes)

    def forward(self, x):
        for conv in self.convs:
            # Frames are images of a batch of their own.
            x = conv(x).permute(0, 4, 1, 2, 3)
            images = nn.functional.max_pool2d(x.flatten(0, 1), 2, 2, ceil_mode=True)
            x = images.unflatten(0, x.shape[:2]).permute(0, 2, 3, 4, 1)
        return self.fc(self.gru(x.mean((2, 3)).transpose(1, 2))[0][:, -1])


class Scale(nn.Module):
    """One scale of Zhang et al. 2022: convolution of 3, batch norm, pool."""

    def __init__(self, inputs, outputs):
        super().__init__()
        self.conv = nn.Conv2d(inputs, outputs, 3, padding=1)
        self.bn = nn.BatchNorm2d(outputs)

    def forward(self, x):
        return nn.functional.max_pool2d(self.bn(self.conv(x)), 2)


class MultiscaleBlock(nn.Module):
    def __init__(self, inputs, multi):
        super().__init__()
        self.k1 = nn.Parameter(torch.ones(1))
        self.k2 = nn.Parameter(torch.ones(1))
        self.single = Scale(inputs, 1)
        self.multi = Scale(inputs, multi)

    def forward(self, x):
        return torch.cat([self.k1 * self.single(x), self.k2 * self.multi(x), nn.functional.max_pool2d(x, 2)], 1)


class Multiscale(nn.Module):
    """Zhang et al. 2022, Table 1."""

    def __init__(self, classes=20, in_channels=2, height=23, width=300, activation="leaky-relu"):
        super().__init__()
        self.activation = torch.sigmoid if activation == "sigmoid" else nn.functional.leaky_relu
        channels = in_channels
        for i, multi in enumerate([5, 15, 32]):
            setattr(self, f"block{i + 1}", MultiscaleBlock(channels, multi))
            channels += 1 + multi
        self.fc1 = nn.Linear(channels * (height // 8) * (width // 8), 512)
        self.bn1 = nn.BatchNorm1d(512)
        self.fc2 = nn.Linear(512, classes)
        self.bn2 = nn.BatchNorm1d(classes)

    def forward(self, x):
        for block in (self.block1, self.block2, self.block3):
            x = self.activation(block(x))
        return self.bn2(self.fc2(torch.sigmoid(self.bn1(self.fc1(x.flatten(1))))))


class DilatedBlock(nn.Module):
    def __init__(self, width, dilation):
        super().__init__()
        layer = lambda: nn.Conv1d(width, width, 3, padding=dilation, dilation=dilation, bias=False)  # noqa: E731
        self.conv1 = nn.Sequential(OrderedDict(conv=layer(), bn=nn.BatchNorm1d(width)))
        self.conv2 = nn.Sequential(OrderedDict(conv=layer(), bn=nn.BatchNorm1d(width)))

    def forward(self, x):
        return torch.relu(self.conv2(torch.relu(self.conv1(x))) + x)


class DilatedResNet(nn.Module):
    """taxel's own: 1x1 convolution, two residual blocks, mean, maximum and deviation over time."""

    def __init__(self, classes=3, in_channels=500, length=25, width=64):
        super().__init__()
        self.stem = nn.Sequential(OrderedDict(conv=nn.Conv1d(in_channels, width, 1, bias=False), bn=nn.BatchNorm1d(width)))
        self.drop1 = nn.Dropout(0.1)
        self.block1, self.block2 = DilatedBlock(width, 1), DilatedBlock(width, 2)
        self.norm = nn.BatchNorm1d(3 * width)
        self.drop2 = nn.Dropout(0.4)
        self.fc = nn.Linear(3 * width, classes)

    def forward(self, x):
        x = self.block2(self.block1(self.drop1(torch.relu(self.stem(x)))))
        deviation = (x.var(2, unbiased=False) + float(np.float32(1e-5))).sqrt()
        return self.fc(self.drop2(self.norm(torch.cat([x.mean(2), x.amax(2), deviation], 1))))


class RocketMember(nn.Module):
    """A perceptron on MiniRocket's features."""

    def __init__(self, features, hidden, classes):
        super().__init__()
        self.drop1, self.fc1 = nn.Dropout(0.3), nn.Linear(features, hidden)
        self.bn, self.drop2 = nn.BatchNorm1d(hidden), nn.Dropout(0.2)
        self.fc2 = nn.Linear(hidden, classes)

    def forward(self, x):
        return self.fc2(self.drop2(torch.relu(self.bn(self.fc1(self.drop1(x))))))


class DilatedResNetRocket(DilatedResNet):
    """taxel's own: logits of both members added; each has a loss of its own."""

    def __init__(self, classes=3, in_channels=500, length=25, width=64, features=1932, hidden=32):
        super().__init__(classes, in_channels, length, width)
        self.rocket = RocketMember(features, hidden, classes)

    def forward(self, x, features):
        self.members = super().forward(x), self.rocket(features)
        return self.members[0] + self.members[1]


BODIES = {"vgg6-lite": Vgg6Lite, "resnet8-lite": ResNet8Lite, "densenet6-lite": DenseNet6Lite}
GRASP = dict(classes=3, in_channels=5, length=50)
PICTURE = dict(classes=3, in_channels=3, height=50, width=50)
# Odd and uneven sizes, one channel, many classes.
LIGHT_CASES = {
    "vgg6-lite-2d": [dict(in_channels=1, height=28, width=50, classes=22)],
    "resnet8-lite-2d": [dict(in_channels=1, height=27, width=31, classes=4)],
    "densenet6-lite-1d": [dict(in_channels=2, length=37, classes=7)],
}


def light(body, dims):
    """A body in 1D or 2D with a classifier behind its pooled features."""

    def make(classes, in_channels, **_sizes):
        net = BODIES[body](dims, in_channels)
        features = net.forward
        net.fc = nn.Linear(net.width, classes)
        net.forward = lambda x: net.fc(features(x))
        return net

    inputs, published = (SIGNAL, GRASP) if dims == 1 else (IMAGE, PICTURE)
    return Twin(make, published, [inputs], cases=[{}, *LIGHT_CASES.get(f"{body}-{dims}d", [])])


def hybrid(temporal, spatial, fuse=True, cases=()):
    def make(**settings):
        return Hybrid(temporal, spatial, fuse, settings["in_channels"], settings["image_channels"], settings["classes"])

    published = {**GRASP, **PICTURE, "in_channels": 5, "image_channels": 3}
    return Twin(make, published, [SIGNAL, ("image_channels", "height", "width")], cases=[{}, *cases])


def tactnet(widths, cases=()):
    return Twin(lambda **settings: TactNet(widths=widths, **settings), PICTURE, [IMAGE], cases=[{}, *cases])


ACTIVE_KERNELS, PALPATION_KERNELS = [(5, 5, 3), (5, 3, 3)], [(5, 3, 8), (5, 3, 8)]


def squeeze(filters, cases, kernels=ACTIVE_KERNELS, **published):
    """A network of Gandarias et al. 2019b and Pastor et al. 2019: filters, kernels, and what differs from the second row of the former."""
    sizes = dict(classes=9, in_channels=1, height=28, width=50, frames=10)
    make = lambda **settings: TactNet3d(filters, kernels, **settings)  # noqa: E731
    return Twin(make, {**sizes, **published}, [TENSOR], cases, dropouts={"drop3": "fc3/relu/dropout"})


DILATED_DROPOUTS = {"drop1": "stem.bn/relu/dropout", "drop2": "norm/dropout"}
CODE = dict(classes=3, in_channels=500, length=25)

TWINS = {
    "mlp": Twin(Mlp, dict(classes=3, in_features=250, hidden=128), [(1, "in_features")]),
    # Three samples under a batch norm: larger steps carry rounding on.
    "deep-mlp": Twin(DeepMlp, dict(classes=3, in_features=250, hidden=128, layers=3), [(1, "in_features")], rate=0.001),
    "layer-norm-mlp": Twin(LayerNormMlp, dict(classes=3, in_features=250, hidden=128, layers=3), [(1, "in_features")], cases=[{}, dict(in_features=9, hidden=11, layers=2, classes=4)]),
    "lstm": Twin(Lstm, dict(GRASP, hidden=128), [SIGNAL], cases=[{}, dict(in_channels=3, length=17, hidden=20, classes=4)]),
    "fcn-1d": Twin(Fcn, GRASP, [SIGNAL], cases=[dict(in_channels=2, length=11, classes=4)]),
    "ds-cnn-1d": Twin(DsCnn, GRASP, [SIGNAL], cases=[dict(in_channels=2, length=11, classes=4)]),
    "tactnet4": tactnet([8, 16, 32], [dict(in_channels=1, height=28, width=50, classes=22)]),
    "tactnet6": tactnet([8, 16, 32, 64, 128]),
    # At 50x50 two values under a max-pool are 1e-6 apart, and rounding chooses where the gradient goes.
    "tactresnet": Twin(
        TactResNet,
        PICTURE,
        [IMAGE],
        cases=[dict(height=50, width=28), dict(in_channels=1, height=31, width=27, classes=5)],
    ),
    **{f"{body}-{dims}d": light(body, dims) for body in BODIES for dims in (1, 2)},
    "hybrid-vgg": hybrid(Vgg6Lite, Vgg6Lite),
    "hybrid-resnet": hybrid(ResNet8Lite, ResNet8Lite),
    "hybrid-densenet": hybrid(DenseNet6Lite, DenseNet6Lite),
    "hybrid-resvgg": hybrid(
        ResNet8Lite, Vgg6Lite, cases=[dict(in_channels=4, length=41, image_channels=1, height=41, width=33, classes=36)]
    ),
    "hybrid-resvgg-nofc": hybrid(ResNet8Lite, Vgg6Lite, fuse=False),
    "tactnet3d": squeeze([8, 16], [{}, dict(in_channels=2, height=19, width=17, frames=11, pool=2, classes=4)]),
    "tactnet3d-4-8": squeeze([4, 8], [dict(height=12, width=11, frames=7)]),
    "tactnet3d-fc32": squeeze([8, 16], [dict(height=11, width=13, frames=6)], hidden=32),
    "tactnet3d-8-16-32": squeeze([8, 16, 32], [dict(height=15, width=11, frames=8)]),
    "tactnet3d-51": squeeze([16, 32], [dict(height=11, width=8, frames=19)], PALPATION_KERNELS, classes=24, frames=51, dropout=0.7),
    "tactnet6-gru": Twin(
        TactNetGru,
        dict(classes=9, in_channels=1, height=28, width=50, frames=10, hidden=64),
        [TENSOR],
        cases=[{}, dict(in_channels=2, height=11, width=7, frames=5, hidden=12, classes=4)],
    ),
    # Batch norm over three samples whose features hardly differ, less still after a sigmoid: PyTorch's own
    # float32 is 8.5e-5 from float64 there.
    "multiscale-cnn": Twin(
        Multiscale,
        dict(classes=20, in_channels=2, height=23, width=300),
        [IMAGE],
        cases=[{}, dict(in_channels=1, height=17, width=26, activation="sigmoid", classes=5)],
        tolerance=lambda settings: dict(DEEP, values=5e-4) if "activation" in settings else DEEP,
    ),
    # With the 500 rows of five channels, two values under the maximum are so close that rounding chooses.
    "dilated-resnet-1d": Twin(
        DilatedResNet,
        CODE,
        [SIGNAL],
        cases=[dict(in_channels=100), dict(in_channels=7, length=11, width=5, classes=4)],
        dropouts=DILATED_DROPOUTS,
    ),
    "dilated-resnet-rocket-1d": Twin(
        DilatedResNetRocket,
        dict(CODE, features=1932),
        [SIGNAL, ("features",)],
        cases=[dict(in_channels=7, length=11, width=5, features=84, hidden=6, classes=4)],
        dropouts={**DILATED_DROPOUTS, "rocket.drop1": "rocket/dropout", "rocket.drop2": "rocket.bn/relu/dropout"},
    ),
    **image_networks.TWINS,
}


def build(name, **settings):
    """The network `name` with `settings` in place of the paper's values."""
    return TWINS[name].build(settings)


def input_shapes(name, **settings):
    """Shapes of the inputs in order, batch axis left out."""
    return TWINS[name].input_shapes(settings)
